#include "lib/hal/drivers/live_clock.h"

#include <thread>

namespace secondlook::hal {

LiveClock::LiveClock()
    : start_(std::chrono::duration_cast<Duration>(
          std::chrono::system_clock::now().time_since_epoch())),
      steady_start_(std::chrono::steady_clock::now()) {}

Time LiveClock::Now() const {
  return start_ +
         std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now() - steady_start_);
}

void LiveClock::SleepUntil(Time time) {
  std::this_thread::sleep_until(steady_start_ + (time - start_));
}

}  // namespace secondlook::hal
