#include "lib/hal/drivers/base_path.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kReachedMetres = 0.1;
constexpr double kReachedYaw = 5.0 * kDegree;

}  // namespace

bool IsReached(const Pose2& X_WB, const Pose2& goal_WB) {
  return std::hypot(X_WB.x - goal_WB.x, X_WB.y - goal_WB.y) <= kReachedMetres &&
         std::abs(WrapAngle(X_WB.yaw - goal_WB.yaw)) <= kReachedYaw;
}

void CheckPath(const BasePath& path, const std::string& base) {
  if (path.waypoints_W.empty()) {
    Throw<InvalidArgument>("base '{}': the path has no waypoint", base);
  }
  for (std::size_t i = 0; i < path.waypoints_W.size(); ++i) {
    const Pose2& w = path.waypoints_W[i];
    if (std::isfinite(w.x) && std::isfinite(w.y) && std::isfinite(w.yaw)) continue;
    Throw<InvalidArgument>("base '{}': waypoint {} of the path, ({}, {}, {}), is not finite", base,
                           i, w.x, w.y, w.yaw);
  }
}

std::string ToText(const Pose2& X_WB) {
  return fmt::format("({:.2f}, {:.2f}) m, {:.0f} deg", X_WB.x, X_WB.y, X_WB.yaw / kDegree);
}

}  // namespace secondlook::hal
