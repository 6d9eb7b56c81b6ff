#pragma once

#include <chrono>
#include <compare>
#include <cstdint>

namespace secondlook {

/// A span of robot time, in nanoseconds.
using Duration = std::chrono::nanoseconds;

/// The clock that robot times belong to. Its epoch is the backend's choice: the Unix epoch on a
/// live robot, the mission's start in simulation, the recording's own in replay.
struct RobotTime {
  using rep = Duration::rep;
  using period = Duration::period;
  using duration = Duration;
  using time_point = std::chrono::time_point<RobotTime, Duration>;
  static constexpr bool is_steady = true;
};

/// An instant of robot time. A measurement's time is when it was *measured*, not when it arrived.
using Time = RobotTime::time_point;

/// Seconds to a Duration, rounded to the nearest nanosecond. @pre |seconds| < 9e9.
constexpr Duration Seconds(double seconds) {
  return Duration(static_cast<std::int64_t>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5)));
}

/// A Duration to seconds.
constexpr double ToSeconds(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

/// An instant to seconds since its clock's epoch.
constexpr double ToSeconds(Time time) { return ToSeconds(time.time_since_epoch()); }

}  // namespace secondlook
