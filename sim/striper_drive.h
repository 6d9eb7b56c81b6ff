#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "lib/common/bounded_queue.h"
#include "lib/common/pose.h"
#include "lib/common/time.h"
#include "sim/noise.h"

namespace secondlook::sim {

/// A line that the laser drew: when, and where it truly was then.
struct Shot {
  Time time{};
  std::uint64_t sequence{};
  Pose X_WL{Pose::Identity()};
};

/// The laser of the simulated robot, behind SimStriper: 50 lines a second, at the instants that are
/// multiples of 20 ms, each of which arrives 20 ms later. It sits a little beside where the
/// calibration says, the same for a whole mission.
/// Threading: RequestOff() from any thread, the rest from the one that steps the world.
class StriperDrive {
 public:
  static constexpr Duration kPeriod = Seconds(0.02);

  /// @param X_EL On the flange, as calibrated.
  /// @param held Lines that wait at most to be taken.
  StriperDrive(const Pose& X_EL, int held, const NoiseConfig& noise, std::uint64_t seed);

  /// Lights the laser until `attended_until`.
  void Light(Time attended_until);
  void RequestOff() noexcept { lit_ = false; }
  bool lit() const { return lit_; }
  /// Its light lasts until then, if it is on.
  void Attend(Time attended_until) { attended_until_ = attended_until; }

  /// At `now` the flange truly is at `X_WE`.
  void Step(Time now, const Pose& X_WE);

  /// The lines that have arrived since the last call.
  std::vector<Shot> Take() { return arrived_.TakeAll(); }
  std::uint64_t lost() const { return arrived_.dropped(); }

 private:
  Pose X_EL_;  // true
  std::atomic<bool> lit_{false};
  Time attended_until_{};
  std::uint64_t sequence_{};
  std::optional<Shot> under_way_;
  BoundedQueue<Shot> arrived_;
};

}  // namespace secondlook::sim
