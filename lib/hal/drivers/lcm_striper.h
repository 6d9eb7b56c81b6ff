#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "lib/common/clock.h"
#include "lib/hal/drivers/lcm_link.h"
#include "lib/hal/laser_striper.h"

namespace secondlook::hal {

struct LcmStriperConfig {
  static constexpr const char* kTag = "Lcm";

  std::string name{"striper"};
  int points{640};                  ///< Of a line.
  double field_of_view_deg{14.25};  ///< From the first ray to the last.
  double min_range{0.3};            ///< Nothing nearer is taken for measured [m] …
  double max_range{0.6};            ///< … nor farther.
  double lines_per_second{50.0};
  double range_sigma{0.0001};    ///< [m]
  int held{100};                 ///< Lines that wait at most to be taken.
  double patience_seconds{1.0};  ///< Without a status, or a good line, for so long it is lost.
  /// Its stamps are by the clock of this machine, or one kept equal to it (NTP, PTP). False: by a
  /// clock of its own, and the quickest message tells how the two stand.
  bool synchronised{true};
  double latency_seconds{0.005};  ///< Unless synchronised: from measurement to arrival, at least.

  template <class A>
  void Serialize(A* a) {
    a->Visit("name", &name);
    a->Visit("points", &points);
    a->Visit("field_of_view_deg", &field_of_view_deg);
    a->Visit("min_range", &min_range);
    a->Visit("max_range", &max_range);
    a->Visit("lines_per_second", &lines_per_second);
    a->Visit("range_sigma", &range_sigma);
    a->Visit("held", &held);
    a->Visit("patience_seconds", &patience_seconds);
    a->Visit("synchronised", &synchronised);
    a->Visit("latency_seconds", &latency_seconds);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// Any line scanner whose lines somebody sends over LCM (docs/real_robot.md). The light is asked
/// for again and again, by Take(); whoever sends must switch it off when that is not heard.
class LcmStriper : public LaserStriper {
 public:
  /// Waits for the first status.
  /// @param link, clock Not null; the clock outlives both this and the link.
  /// @throws ConfigError; DeviceError naming the striper when no status came, and why.
  LcmStriper(const LcmStriperConfig& config, std::shared_ptr<LcmLink> link, const Clock* clock);
  ~LcmStriper() override;

  const StriperInfo& info() const override { return info_; }
  void On() override;
  void Off() noexcept override;
  std::vector<ScanLine> Take() override;
  std::uint64_t lost() const override;

 private:
  class Inbox;

  void Command(bool on);
  /// @throws DeviceError when it is lost, or cannot measure.
  void RequireThere() const;

  const LcmStriperConfig config_;
  const std::shared_ptr<LcmLink> link_;
  const Clock* clock_;
  StriperInfo info_;
  std::shared_ptr<Inbox> inbox_;  ///< The link keeps it, too.
  std::atomic<bool> on_{false};
  Time on_since_{};
  Time commanded_{};       ///< When it was last told to be on.
  Time attended_until_{};  ///< On no longer than this.
};

}  // namespace secondlook::hal
