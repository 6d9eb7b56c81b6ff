#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/kinematics/robot_model.h"

namespace secondlook::kinematics {

/// The revolute joints from the root link of a robot, which is its frame B, to a tip link, its
/// end-effector frame E (KDL). Joints that are not on the way are held at 0, or at the limit next
/// to it. Copies share what never changes. Threading: any number of threads.
class Chain {
 public:
  /// @throws ConfigError when there is no such tip, or no joint on the way to it.
  Chain(RobotModel model, const std::string& tip);
  ~Chain();
  Chain(const Chain&) = default;
  Chain& operator=(const Chain&) = default;

  const RobotModel& model() const;
  /// The link whose frame is E.
  const Link& tip() const;
  /// How many joints there are.
  int size() const;
  /// Joint `i`, counted from the base, and the index of the link that it moves.
  const Joint& joint(int i) const;
  int link_of(int i) const;
  /// True when some joint of the chain moves the link of that index.
  bool Moves(int link) const;

  /// True when every angle lies within its limits. @pre q has size() values, here and below.
  bool WithinLimits(const Eigen::VectorXd& q) const;

  /// X_BE at the joint angles `q` [rad].
  Pose TipPose(const Eigen::VectorXd& q) const;

  /// The velocity of E's origin (upper three rows, [m/s]) and the angular velocity of E (lower
  /// three, [rad/s]), both in B, for each joint's velocity.
  Eigen::Matrix<double, 6, Eigen::Dynamic> Jacobian(const Eigen::VectorXd& q) const;

  /// The pose X_BL of every link of the model, by index.
  std::vector<Pose> LinkPoses(const Eigen::VectorXd& q) const;

  /// The bodies of all links, in B.
  std::vector<geometry::PlacedShape> Body(const Eigen::VectorXd& q) const;

 private:
  struct Parts;
  std::shared_ptr<const Parts> parts_;  // never changes, so that copies may share it
};

}  // namespace secondlook::kinematics
