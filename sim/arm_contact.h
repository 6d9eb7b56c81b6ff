#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/kinematics/chain.h"
#include "sim/fixtures.h"

namespace secondlook::sim {

/// What the arm touches, and about where.
struct ArmTouch {
  std::string name;
  Eigen::Vector3d point_W{0.0, 0.0, 0.0};  ///< [m]
};

/// Tells what the links that the arm's joints move touch: the exact bodies against the surfaces of
/// all fixtures (FCL), whatever anybody has measured.
class ArmContact {
 public:
  /// `fixtures` and `chain` are not kept.
  ArmContact(const std::vector<Fixture>& fixtures, const kinematics::Chain& chain);
  ~ArmContact();

  /// Each thing once, in the order of the fixtures.
  /// @param X_BL The pose of every link in the base.
  std::vector<ArmTouch> Touches(const Pose& X_WB, const std::vector<Pose>& X_BL) const;

 private:
  struct Shapes;
  std::unique_ptr<Shapes> shapes_;
};

}  // namespace secondlook::sim
