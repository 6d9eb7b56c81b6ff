#pragma once

#include <chrono>

#include "lib/common/clock.h"

namespace secondlook::hal {

/// The time of a robot that is there: since the Unix epoch, as the machine had it when this was
/// made, and from then on steadily, however the machine's clock is set meanwhile.
class LiveClock : public Clock {
 public:
  LiveClock();

  Time Now() const override;
  void SleepUntil(Time time) override;
  void ChargeThinking(Duration) override {}

 private:
  Time start_;
  std::chrono::steady_clock::time_point steady_start_;
};

}  // namespace secondlook::hal
