#pragma once

#include <string>

namespace secondlook::hal {

/// How far an actuator is with the last plan it was given.
enum class MotionPhase {
  kIdle,     ///< Nothing was started yet.
  kMoving,   ///< On its way.
  kReached,  ///< Arrived, exactly: within the tolerance that the device's header states.
  kFailed,   ///< Gave up and stands still; `reason` says why.
  kStopped,  ///< Stop() ended it, and it stands still.
};

/// The answer to Status(): a value, never an exception, for all that can go wrong on the way.
struct MotionStatus {
  MotionPhase phase{MotionPhase::kIdle};
  std::string reason;  ///< Why it failed, with values; empty otherwise.
};

}  // namespace secondlook::hal
