#pragma once

#include <algorithm>
#include <optional>

#include "lib/common/time.h"

namespace secondlook::hal {

/// Brings the stamps of a device that has a clock of its own to robot time. What arrives was
/// delayed on its way, by differing amounts, so the least difference between arrival and stamp that
/// was seen tells how the clocks stand. It is let grow slowly, so that clocks which run apart are
/// followed.
class DeviceTime {
 public:
  /// @param latency What even the quickest message takes from measurement to arrival.
  explicit DeviceTime(Duration latency) : latency_(latency) {}

  /// Robot time of a measurement that the device stamped `stamp` (since any epoch of its own) and
  /// that arrived at `arrival`; never after that.
  Time Of(Duration stamp, Time arrival) {
    const Duration offset = arrival.time_since_epoch() - stamp;
    // A device that began anew has another epoch.
    const bool known = offset_ && offset - *offset_ < kAnew && *offset_ - offset < kAnew;
    offset_ = known ? std::min(offset, *offset_ + kDrift) : offset;
    return std::min(Time(stamp + *offset_), arrival) - latency_;
  }

 private:
  static constexpr Duration kAnew = Seconds(1.0);
  static constexpr Duration kDrift = Duration(3'000);  // a message: 100 ppm at 30 messages a second

  Duration latency_;
  std::optional<Duration> offset_;
};

}  // namespace secondlook::hal
