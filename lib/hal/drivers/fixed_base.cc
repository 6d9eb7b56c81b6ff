#include "lib/hal/drivers/fixed_base.h"

#include <numbers>

#include <fmt/format.h>

#include "lib/common/check_range.h"
#include "lib/hal/drivers/base_path.h"

namespace secondlook::hal {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace

void FixedBaseConfig::Validate() const {
  CheckRange(x, -1e4, 1e4, "'x'");
  CheckRange(y, -1e4, 1e4, "'y'");
  CheckRange(yaw_deg, -360.0, 360.0, "'yaw_deg'");
  CheckRange(radius, 0.01, 5.0, "'radius'");
  CheckRange(height, 0.01, 5.0, "'height'");
}

FixedBase::FixedBase(const FixedBaseConfig& config, const Clock* clock)
    : clock_(clock), X_WB_{config.x, config.y, WrapAngle(config.yaw_deg * kDegree)} {
  config.Validate();
  info_ = {"base", config.radius, config.height, 1.0, 1.0};  // speeds that it never drives at
}

BaseState FixedBase::State() { return {clock_->Now(), X_WB_, X_WB_}; }

void FixedBase::Start(const BasePath& path) {
  CheckPath(path, info_.name);
  const Pose2& goal = path.waypoints_W.back();
  if (IsReached(X_WB_, goal)) {
    status_ = {MotionPhase::kReached, ""};
  } else {
    status_ = {MotionPhase::kFailed, fmt::format("{}: it is fixed, and cannot drive from {} to {}",
                                                 info_.name, ToText(X_WB_), ToText(goal))};
  }
}

}  // namespace secondlook::hal
