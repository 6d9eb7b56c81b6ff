#pragma once

#include <optional>

#include "lib/common/error.h"
#include "lib/common/time.h"
#include "lib/hal/robot.h"

namespace secondlook::hal {

/// The calls on a robot's devices that can fail.
enum class Call {
  kBaseState,
  kBaseStart,
  kBaseStatus,
  kHeadState,
  kHeadStart,
  kHeadStatus,
  kGrab,
  kArmState,
  kArmStart,
  kArmStatus,
  kHandGrab,
};

/// Is told what the devices of a tapped robot answer. Each function is called right after the
/// device has answered, by the thread that asked; what it does not care for it need not override.
class RobotListener {
 public:
  RobotListener() = default;
  RobotListener(const RobotListener&) = delete;
  RobotListener& operator=(const RobotListener&) = delete;
  virtual ~RobotListener() = default;

  /// Now() was asked by the thread that tapped the robot. What other threads ask is not told.
  virtual void OnNow(Time /*now*/) {}
  /// SleepUntil(`until`) returned at `now`.
  virtual void OnSleep(Time /*until*/, Time /*now*/) {}
  /// ChargeThinking(`cost`) returned at `now`.
  virtual void OnThinking(Duration /*cost*/, Time /*now*/) {}

  virtual void OnBaseState(const BaseState& /*state*/) {}
  virtual void OnBaseStart(const BasePath& /*path*/) {}
  virtual void OnBaseStatus(const MotionStatus& /*status*/) {}

  virtual void OnHeadState(const PanTiltState& /*state*/) {}
  virtual void OnHeadStart(const PanTiltAngles& /*target*/) {}
  virtual void OnHeadStatus(const MotionStatus& /*status*/) {}

  virtual void OnArmState(const ArmState& /*state*/) {}
  virtual void OnArmStart(const JointTrajectory& /*trajectory*/) {}
  virtual void OnArmStatus(const MotionStatus& /*status*/) {}

  /// Grab() of the head's camera returned at `now`, with a frame or without.
  virtual void OnFrame(const std::optional<RgbdFrame>& /*frame*/, Time /*now*/) {}
  /// Likewise that of the hand's camera.
  virtual void OnHandFrame(const std::optional<RgbdFrame>& /*frame*/, Time /*now*/) {}

  /// The call threw `error`, at `now`, instead of returning.
  virtual void OnError(Call /*call*/, const Error& /*error*/, Time /*now*/) {}
};

/// The same robot, with `listener`, which must outlive it, told every answer but the striper's.
/// Stop() passes straight through from any thread.
Robot Tap(Robot robot, RobotListener* listener);

}  // namespace secondlook::hal
