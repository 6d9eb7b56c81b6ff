#include "lib/hal/drivers/fixed_head.h"

#include <numbers>

#include "lib/common/check_range.h"
#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace

void FixedHeadConfig::Validate() const {
  CheckRange(pan_deg, -180.0, 180.0, "'pan_deg'");
  CheckRange(tilt_deg, -90.0, 90.0, "'tilt_deg'");
}

FixedHead::FixedHead(const FixedHeadConfig& config, const Clock* clock) : clock_(clock) {
  config.Validate();
  const PanTiltAngles at{config.pan_deg * kDegree, config.tilt_deg * kDegree};
  info_ = {"head", at, at, 1.0};  // a speed that it never turns at
}

void FixedHead::Start(const PanTiltAngles& target) {
  if (!info_.Reaches(target)) {
    Throw<InvalidArgument>(
        "{}: pan {:.2f}, tilt {:.2f} deg is outside its limits: it is fixed at pan {:.2f}, tilt "
        "{:.2f} deg",
        info_.name, target.pan / kDegree, target.tilt / kDegree, info_.lower.pan / kDegree,
        info_.lower.tilt / kDegree);
  }
  status_ = {MotionPhase::kReached, ""};
}

}  // namespace secondlook::hal
