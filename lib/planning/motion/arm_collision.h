#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/kinematics/chain.h"
#include "lib/planning/motion/obstacles.h"

namespace secondlook::planning {

struct ArmCollisionConfig {
  double clearance_m{0.03};       ///< Kept from obstacles: the body is grown by so much.
  double self_clearance_m{0.01};  ///< Kept between the robot's own links.

  template <class A>
  void Serialize(A* a) {
    a->Visit("clearance_m", &clearance_m);
    a->Visit("self_clearance_m", &self_clearance_m);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// How far a point of the body moves at most per angle of each joint [m/rad]: no point that the
/// joint moves is farther from its axis.
std::vector<double> MotionRadii(const kinematics::Chain& chain);

/// From the first joint to the farthest point of the body in any posture, at most [m].
double ReachOf(const kinematics::Chain& chain);

/// Tests whether an arm would touch anything in some posture (FCL): every link that its joints move
/// against the obstacles, and against all other links of the robot but those a single joint away.
/// Threading: one thread.
class ArmCollision {
 public:
  /// @param X_WB Where the robot stands.
  /// @throws ConfigError when `config` is not valid.
  ArmCollision(kinematics::Chain chain, const Pose& X_WB, const std::vector<Obstacle>& obstacles_W,
               const ArmCollisionConfig& config = {});
  ~ArmCollision();
  ArmCollision(ArmCollision&&) noexcept;
  ArmCollision& operator=(ArmCollision&&) noexcept;

  const kinematics::Chain& chain() const;
  const ArmCollisionConfig& config() const;

  /// What touches what at the joint angles `q` [rad], in words: "link 'link_5' with occupied space
  /// at (0.61, 0.10, 0.92) m in W". Empty when the arm is free.
  /// @pre q has a value for each joint.
  std::optional<std::string> Touches(const Eigen::VectorXd& q) const;

  /// The same without the words, which take longer.
  bool Free(const Eigen::VectorXd& q) const;

 private:
  struct Shapes;
  std::unique_ptr<Shapes> shapes_;
};

}  // namespace secondlook::planning
