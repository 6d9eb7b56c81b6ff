#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/hal/joint_trajectory.h"

namespace secondlook::planning {

/// The quickest trajectory that goes straight, in joint angles, from waypoint to waypoint and
/// stands at each: all joints together speed up, cruise and brake as hard as the limits of the
/// slowest allow. Waypoints that repeat the one before are left out.
/// @param waypoints At least one; each has an angle for each joint [rad].
/// @throws InvalidArgument when there is none, or one has the wrong size or is not finite.
hal::JointTrajectory StopAndGo(const std::vector<Eigen::VectorXd>& waypoints,
                               const std::vector<hal::JointInfo>& joints);

/// The same joints, with so much of their limits of speed and acceleration.
std::vector<hal::JointInfo> Gently(std::vector<hal::JointInfo> joints, double speed_share);

/// Seconds that StopAndGo() takes from `a` to `b`.
double SecondsBetween(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                      const std::vector<hal::JointInfo>& joints);

}  // namespace secondlook::planning
