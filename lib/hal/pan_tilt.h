#pragma once

#include <string>

#include "lib/common/time.h"
#include "lib/hal/motion.h"

namespace secondlook::hal {

/// Where a pan-tilt head looks. At (0, 0) its frame H is aligned with its mount: x forward, y left,
/// z up. Pan turns about z (positive: left), then tilt about y (positive: down).
struct PanTiltAngles {
  double pan{};   ///< [rad]
  double tilt{};  ///< [rad]

  friend bool operator==(const PanTiltAngles&, const PanTiltAngles&) = default;
};

/// What a pan-tilt head is. Constant for its lifetime.
struct PanTiltInfo {
  std::string name;     ///< What messages call it.
  PanTiltAngles lower;  ///< Both limits [rad], lower <= upper.
  PanTiltAngles upper;
  double speed{};  ///< Of each axis [rad/s], > 0.

  /// True when both angles lie within the limits.
  bool Reaches(const PanTiltAngles& angles) const {
    return angles.pan >= lower.pan && angles.pan <= upper.pan && angles.tilt >= lower.tilt &&
           angles.tilt <= upper.tilt;
  }
};

/// The measured angles of a pan-tilt head.
struct PanTiltState {
  Time time{};           ///< Of the measurement.
  PanTiltAngles angles;  ///< As its encoders say.
};

/// A pan-tilt head: a real unit, a replayed log or the simulation. Every backend passes
/// tests/hal/pan_tilt_contract.h.
/// Threading: Stop() from any thread, the rest from one.
class PanTilt {
 public:
  PanTilt(const PanTilt&) = delete;
  PanTilt& operator=(const PanTilt&) = delete;
  /// Leaves the head standing still.
  virtual ~PanTilt() = default;

  virtual const PanTiltInfo& info() const = 0;

  /// The newest state. Times never decrease.
  /// @throws DeviceError naming the head if it is lost.
  virtual PanTiltState State() = 0;

  /// Begins to turn and returns at once; a motion in progress is replaced. Nothing is clamped.
  /// @throws InvalidArgument naming the limits when `target` lies outside them or is not finite.
  /// @throws DeviceError naming the head if it is lost.
  virtual void Start(const PanTiltAngles& target) = 0;

  /// How far the last motion is. kReached: within 0.5 degrees by the encoders, and standing still.
  virtual MotionStatus Status() = 0;

  /// Stands still as soon as it can. Always possible, also when nothing moves.
  virtual void Stop() noexcept = 0;

 protected:
  PanTilt() = default;
};

}  // namespace secondlook::hal
