#include "sim/head_drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lib/common/error.h"

namespace secondlook::sim {
namespace {

constexpr RampLimits kAxis{1.5, 6.0};  // [rad/s], [rad/s^2]
constexpr double kErrorSettles = 0.1;  // [s] of moving until the error is another
constexpr double kDegrees = 180.0 / std::numbers::pi;

}  // namespace

HeadDrive::HeadDrive(const NoiseConfig& noise, std::uint64_t seed)
    : noise_(noise), rng_(ForkSeed(seed, "head")) {
  error_ = DrawError();
  error_before_ = error_;
  error_after_ = error_;
}

const hal::PanTiltInfo& HeadDrive::Info() {
  static const hal::PanTiltInfo info{"head", {-2.6, -0.5}, {2.6, 1.0}, kAxis.speed};
  return info;
}

hal::PanTiltAngles HeadDrive::DrawError() {
  const double sigma = noise_.pan_tilt_sigma_deg / kDegrees;
  const double pan = rng_.Gaussian(sigma);
  return {pan, rng_.Gaussian(sigma)};
}

void HeadDrive::Start(const hal::PanTiltAngles& target) {
  const hal::PanTiltInfo& info = Info();
  if (!info.Reaches(target)) {  // nor does anything that is not finite
    Throw<InvalidArgument>(
        "pan-tilt '{}' cannot turn to pan {:.2f}, tilt {:.2f} deg; its limits are pan {:.2f} to "
        "{:.2f}, tilt {:.2f} to {:.2f} deg",
        info.name, target.pan * kDegrees, target.tilt * kDegrees, info.lower.pan * kDegrees,
        info.upper.pan * kDegrees, info.lower.tilt * kDegrees, info.upper.tilt * kDegrees);
  }
  target_ = target;
  status_ = {hal::MotionPhase::kMoving, ""};
  stop_requested_ = false;
  error_before_ = error_;
  error_after_ = DrawError();
  error_blend_ = 0.0;
}

void HeadDrive::Step(double dt) {
  if (status_.phase != hal::MotionPhase::kMoving) {
    stop_requested_ = false;
    return;
  }
  const bool stopping = stop_requested_;
  if (stopping) {
    encoders_.pan += pan_.Brake(kAxis, dt);
    encoders_.tilt += tilt_.Brake(kAxis, dt);
  } else {
    encoders_.pan += pan_.Approach(target_.pan - encoders_.pan, kAxis, dt);
    encoders_.tilt += tilt_.Approach(target_.tilt - encoders_.tilt, kAxis, dt);
  }
  error_blend_ = std::min(1.0, error_blend_ + dt / kErrorSettles);
  error_.pan = error_before_.pan + error_blend_ * (error_after_.pan - error_before_.pan);
  error_.tilt = error_before_.tilt + error_blend_ * (error_after_.tilt - error_before_.tilt);
  if (!Stands() || (!stopping && encoders_ != target_)) return;
  status_ = {stopping ? hal::MotionPhase::kStopped : hal::MotionPhase::kReached, ""};
  stop_requested_ = false;
}

hal::PanTiltAngles HeadDrive::Truth() const {
  return {encoders_.pan + error_.pan, encoders_.tilt + error_.tilt};
}

}  // namespace secondlook::sim
