#include "sim/walker.h"

#include <algorithm>

namespace secondlook::sim {
namespace {

constexpr double kKeepsFrom = 0.05;  // [m] between it and the robot

}  // namespace

Walker::Walker(const MovingObstacle& obstacle)
    : obstacle_(obstacle), position_W_(obstacle.waypoints.front()) {}

void Walker::Step(double dt, const Disc& robot) {
  const std::size_t count = obstacle_.waypoints.size();
  if (count < 2) return;
  const Eigen::Vector2d way = obstacle_.waypoints[next_] - position_W_;
  const double step = std::min(obstacle_.speed * dt, way.norm());
  if (way.norm() > 0.0) {
    const Eigen::Vector2d there = position_W_ + way.normalized() * step;
    const double now = (position_W_ - robot.center_W).norm();
    const double then = (there - robot.center_W).norm();
    if (then < now && then < robot.radius + obstacle_.radius + kKeepsFrom) return;
    position_W_ = there;
  }
  if (position_W_ != obstacle_.waypoints[next_]) return;
  if (forward_ && next_ + 1 == count) forward_ = false;
  if (!forward_ && next_ == 0) forward_ = true;
  next_ = forward_ ? next_ + 1 : next_ - 1;
}

}  // namespace secondlook::sim
