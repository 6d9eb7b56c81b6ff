#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/hal/joint_trajectory.h"

namespace secondlook::planning {

/// The way that an arm has come since it was folded, so that it can always go back: its body has
/// just passed through all of it, whatever the map says of the place since.
class ArmWay {
 public:
  /// It is folded at `home` [rad].
  explicit ArmWay(const Eigen::VectorXd& home) : waypoints_{home} {}

  /// Where it is folded [rad].
  const Eigen::VectorXd& home() const { return waypoints_.front(); }

  /// It has set out along `trajectory`, which goes straight between the knots at which it stands
  /// (StopAndGo), and has got as far as `q`: its end, or anywhere on the way.
  void Follow(const hal::JointTrajectory& trajectory, const Eigen::VectorXd& q);

  /// The motion from `q`, at the end of the way, to where the arm is folded; empty when it is.
  /// @param joints With the limits that are to be kept.
  hal::JointTrajectory Back(const Eigen::VectorXd& q,
                            const std::vector<hal::JointInfo>& joints) const;

 private:
  std::vector<Eigen::VectorXd> waypoints_;  // from home to where it is
};

}  // namespace secondlook::planning
