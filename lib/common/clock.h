#pragma once

#include "lib/common/time.h"

namespace secondlook {

/// Robot time: live, simulated or replayed. Nothing else in the project may read a clock, so that a
/// mission in simulation depends on its seed alone.
/// Threading: Now() from any thread; SleepUntil() and ChargeThinking() from the mission thread.
class Clock {
 public:
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;
  virtual ~Clock() = default;

  /// The present instant; never runs backwards.
  virtual Time Now() const = 0;

  /// Returns once Now() >= `time`; at once when that has passed already. In simulation this is what
  /// steps the world.
  virtual void SleepUntil(Time time) = 0;

  /// Accounts for a stage of our own thinking whose configured cost is `cost` >= 0. A live clock
  /// returns at once, as the time has truly passed; a simulated one steps the world by `cost`, so
  /// that obstacles move while the robot thinks.
  virtual void ChargeThinking(Duration cost) = 0;

 protected:
  Clock() = default;
};

}  // namespace secondlook
