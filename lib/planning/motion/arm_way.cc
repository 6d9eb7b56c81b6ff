#include "lib/planning/motion/arm_way.h"

#include <algorithm>
#include <limits>

#include "lib/planning/motion/stop_and_go.h"

namespace secondlook::planning {
namespace {

/// A folded arm is so near to its home [rad], each joint.
constexpr double kFolded = 0.01;

/// From `q` to the straight way between `a` and `b` [rad].
double DistanceTo(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& q) {
  const Eigen::VectorXd way = b - a;
  const double length2 = way.squaredNorm();
  const double share = length2 > 0.0 ? std::clamp(way.dot(q - a) / length2, 0.0, 1.0) : 0.0;
  return (q - (a + share * way)).norm();
}

}  // namespace

void ArmWay::Follow(const hal::JointTrajectory& trajectory, const Eigen::VectorXd& q) {
  for (const hal::JointKnot& knot : trajectory.knots) {
    if (knot.v.isZero()) waypoints_.push_back(knot.q);
  }
  // What lies behind the place where it stands now is no part of the way to it.
  std::size_t last = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < waypoints_.size(); ++i) {
    const double distance = DistanceTo(waypoints_[i], waypoints_[i + 1], q);
    if (distance >= nearest) continue;
    nearest = distance;
    last = i;
  }
  waypoints_.resize(last + 1);
  waypoints_.push_back(q);
}

hal::JointTrajectory ArmWay::Back(const Eigen::VectorXd& q,
                                  const std::vector<hal::JointInfo>& joints) const {
  if ((q - waypoints_.front()).cwiseAbs().maxCoeff() <= kFolded) return {};
  std::vector<Eigen::VectorXd> back{q};
  back.insert(back.end(), std::next(waypoints_.rbegin()), waypoints_.rend());
  return StopAndGo(back, joints);
}

}  // namespace secondlook::planning
