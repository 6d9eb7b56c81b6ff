#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

#include "lib/common/error.h"
#include "lib/common/time.h"
#include "lib/hal/drivers/device_time.h"

namespace secondlook::hal {

/// A stamp in microseconds, none that would not fit. @throws ProtocolError for one before 1970 or
/// after 2096.
inline Duration StampOf(std::int64_t utime) {
  if (utime < 0 || utime > 4'000'000'000'000'000) {
    Throw<ProtocolError>("its stamp of {} us is none since the Unix epoch", utime);
  }
  return std::chrono::microseconds(utime);
}

/// `time` as messages have it.
inline std::int64_t Microseconds(Time time) {
  return std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
}

/// Brings the stamps of whoever sends over a network to robot time.
class SenderTime {
 public:
  /// @param synchronised The sender's clock is this machine's, or kept equal to it. False: it is a
  /// clock of its own, and the quickest message tells how the two stand.
  /// @param max_age Of a message by a clock that is kept equal.
  /// @param latency What even the quickest message takes, by a clock that is not.
  SenderTime(bool synchronised, Duration max_age, Duration latency)
      : synchronised_(synchronised), max_age_(max_age), device_time_(latency) {}

  /// Robot time of a measurement that was stamped `stamp` and arrived at `arrival`; never after
  /// that. @throws ProtocolError for clocks that are not as equal as they should be.
  Time Of(Duration stamp, Time arrival) {
    if (!synchronised_) return device_time_.Of(stamp, arrival);
    const Time time(stamp);
    if (time > arrival + kMaxAhead || time < arrival - max_age_) {
      Throw<ProtocolError>(
          "its stamp is {:.3f} s {} this machine's clock: keep the clocks of both machines equal "
          "(NTP), or set 'synchronised: false'",
          std::abs(ToSeconds(time - arrival)), time > arrival ? "ahead of" : "behind");
    }
    return std::min(time, arrival);
  }

 private:
  static constexpr Duration kMaxAhead = Seconds(0.02);  // of what clocks kept equal may differ

  const bool synchronised_;
  const Duration max_age_;
  DeviceTime device_time_;
};

}  // namespace secondlook::hal
