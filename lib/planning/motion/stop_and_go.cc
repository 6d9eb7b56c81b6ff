#include "lib/planning/motion/stop_and_go.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/common/error.h"

namespace secondlook::planning {
namespace {

constexpr double kSame = 1e-9;  // [rad]

/// How the way from 0 to 1 is covered: speed up for `ramp` seconds, cruise at `speed`, brake.
struct Profile {
  double speed{};         ///< [1/s]
  double acceleration{};  ///< [1/s^2]
  double ramp{};          ///< [s]
  double cruise{};        ///< [s]

  double seconds() const { return 2.0 * ramp + cruise; }
};

/// The quickest one that keeps every joint's limits over `way` [rad].
Profile QuickestOver(const Eigen::VectorXd& way, const std::vector<hal::JointInfo>& joints) {
  Profile profile;
  profile.speed = std::numeric_limits<double>::infinity();
  profile.acceleration = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double angle = std::abs(way[static_cast<Eigen::Index>(i)]);
    if (angle <= kSame) continue;
    profile.speed = std::min(profile.speed, joints[i].speed / angle);
    profile.acceleration = std::min(profile.acceleration, joints[i].acceleration / angle);
  }
  profile.ramp = profile.speed / profile.acceleration;
  if (profile.ramp * profile.speed >= 1.0) {  // too short a way to reach the full speed
    profile.ramp = std::sqrt(1.0 / profile.acceleration);
    profile.speed = profile.ramp * profile.acceleration;
    return profile;
  }
  profile.cruise = 1.0 / profile.speed - profile.ramp;
  return profile;
}

bool Same(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return (a - b).cwiseAbs().maxCoeff() <= kSame;
}

/// Appends the straight way from the last knot to `goal`.
void GoTo(const Eigen::VectorXd& goal, const std::vector<hal::JointInfo>& joints,
          hal::JointTrajectory* trajectory) {
  const hal::JointKnot from = trajectory->knots.back();
  const Eigen::VectorXd way = goal - from.q;
  const Profile profile = QuickestOver(way, joints);
  const double ramped = 0.5 * profile.speed * profile.ramp;  // of the way
  const double up = from.seconds + profile.ramp;
  trajectory->knots.push_back({up, from.q + ramped * way, profile.speed * way});
  if (profile.cruise > 0.0) {
    trajectory->knots.push_back(
        {up + profile.cruise, from.q + (1.0 - ramped) * way, profile.speed * way});
  }
  trajectory->knots.push_back({from.seconds + profile.seconds(), goal, from.v});
}

}  // namespace

hal::JointTrajectory StopAndGo(const std::vector<Eigen::VectorXd>& waypoints,
                               const std::vector<hal::JointInfo>& joints) {
  if (waypoints.empty()) Throw<InvalidArgument>("a joint trajectory without a waypoint");
  const auto size = static_cast<Eigen::Index>(joints.size());
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    if (waypoints[i].size() == size && waypoints[i].allFinite()) continue;
    Throw<InvalidArgument>("waypoint {} of a joint trajectory has not {} finite angles", i, size);
  }
  hal::JointTrajectory trajectory{{{0.0, waypoints.front(), Eigen::VectorXd::Zero(size)}}};
  for (const Eigen::VectorXd& waypoint : waypoints) {
    if (!Same(waypoint, trajectory.knots.back().q)) GoTo(waypoint, joints, &trajectory);
  }
  return trajectory;
}

std::vector<hal::JointInfo> Gently(std::vector<hal::JointInfo> joints, double speed_share) {
  for (hal::JointInfo& joint : joints) {
    joint.speed *= speed_share;
    joint.acceleration *= speed_share;
  }
  return joints;
}

double SecondsBetween(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                      const std::vector<hal::JointInfo>& joints) {
  return Same(a, b) ? 0.0 : QuickestOver(b - a, joints).seconds();
}

}  // namespace secondlook::planning
