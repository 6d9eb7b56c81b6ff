#pragma once

#include <atomic>

#include "lib/common/rng.h"
#include "lib/hal/pan_tilt.h"
#include "sim/noise.h"
#include "sim/ramp.h"

namespace secondlook::sim {

/// The simulated pan-tilt unit itself, behind SimPanTilt. Its encoders say where it was sent; where
/// it truly points is off by an error that changes with each motion.
/// Threading: RequestStop() from any thread, the rest from the one that steps the world.
class HeadDrive {
 public:
  HeadDrive(const NoiseConfig& noise, std::uint64_t seed);

  static const hal::PanTiltInfo& Info();

  /// As hal::PanTilt says. @throws InvalidArgument for a target it refuses.
  void Start(const hal::PanTiltAngles& target);
  void RequestStop() noexcept { stop_requested_ = true; }
  hal::MotionStatus Status() const { return status_; }

  /// Moves on by `dt` [s].
  void Step(double dt);

  /// What its encoders say.
  const hal::PanTiltAngles& encoders() const { return encoders_; }
  /// Where it truly points.
  hal::PanTiltAngles Truth() const;

 private:
  hal::PanTiltAngles DrawError();
  bool Stands() const { return pan_.speed() == 0.0 && tilt_.speed() == 0.0; }

  NoiseConfig noise_;
  Rng rng_;
  hal::PanTiltAngles encoders_;
  hal::PanTiltAngles target_;
  hal::PanTiltAngles error_;
  hal::PanTiltAngles error_before_;
  hal::PanTiltAngles error_after_;
  double error_blend_{1.0};
  Ramp pan_;
  Ramp tilt_;
  hal::MotionStatus status_;
  std::atomic<bool> stop_requested_{false};
};

}  // namespace secondlook::sim
