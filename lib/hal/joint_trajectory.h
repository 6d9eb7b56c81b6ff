#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace secondlook::hal {

/// What one joint of an arm can do. It is a revolute joint.
struct JointInfo {
  std::string name;  ///< What messages call it, e.g. "joint_4".
  double lower{};    ///< Both limits [rad], lower < upper.
  double upper{};
  double speed{};         ///< At most [rad/s], > 0.
  double acceleration{};  ///< At most [rad/s^2], > 0.
};

/// Where the joints are to be at one instant of a trajectory, and how fast they pass there.
struct JointKnot {
  double seconds{};   ///< Since the trajectory began.
  Eigen::VectorXd q;  ///< Positions [rad], base to tip.
  Eigen::VectorXd v;  ///< Velocities [rad/s].
};

/// A motion of all joints together. Between two knots each joint follows the cubic polynomial that
/// has the positions and velocities of both (Hermite).
struct JointTrajectory {
  std::vector<JointKnot> knots;

  /// How long it takes [s]; 0 without a knot.
  double seconds() const { return knots.empty() ? 0.0 : knots.back().seconds; }
};

/// Where the joints are on `trajectory` at `seconds` since its beginning: the first knot before it,
/// the last one after. @pre it has a knot.
JointKnot Sample(const JointTrajectory& trajectory, double seconds);

/// Holds `trajectory` to what an arm may be asked: it has a knot and a value for each of the
/// `joints`; all values are finite; times begin at 0 and increase; it begins where the arm is
/// (`q_measured`, within 1 degree), at rest, and ends at rest; and everywhere, between the knots
/// too, it keeps the limits of position, speed and acceleration.
/// @param arm What messages call the arm.
/// @throws InvalidArgument naming the arm, the joint, the instant and the limit.
void CheckTrajectory(const JointTrajectory& trajectory, const std::string& arm,
                     const std::vector<JointInfo>& joints, const Eigen::VectorXd& q_measured);

}  // namespace secondlook::hal
