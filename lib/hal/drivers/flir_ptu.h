#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "lib/common/clock.h"
#include "lib/hal/drivers/flir_ptu_link.h"
#include "lib/hal/pan_tilt.h"

namespace secondlook::hal {

struct FlirPtuConfig {
  static constexpr const char* kTag = "FlirPtu";

  std::string device{"/dev/ttyUSB0"};
  int baud{9600};
  double speed_deg{60.0};        ///< Of both axes, a second; the unit's own limit where lower.
  bool home{false};              ///< Let the unit find its zero at the start: it turns to its ends.
  bool pan_positive_left{true};  ///< As the unit counts: false where it is mounted upside down.
  bool tilt_positive_up{true};   ///< The D46 looks up with positive tilt.
  double poll_seconds{0.05};     ///< Between two questions for its position.

  template <class A>
  void Serialize(A* a) {
    a->Visit("device", &device);
    a->Visit("baud", &baud);
    a->Visit("speed_deg", &speed_deg);
    a->Visit("home", &home);
    a->Visit("pan_positive_left", &pan_positive_left);
    a->Visit("tilt_positive_up", &tilt_positive_up);
    a->Visit("poll_seconds", &poll_seconds);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A FLIR PTU-D46 or -E46 at a serial port. Its limits and resolution are read from the unit. A
/// thread of its own speaks with it, so that no caller waits; a unit that no longer answers, or
/// whose port is gone, is tried again every second, and what it was doing has failed.
class FlirPtu : public PanTilt {
 public:
  /// Connects, waiting for the unit to be ready.
  /// @param clock Not null; outlives this.
  /// @throws ConfigError, DeviceError naming the port: no such port, no answer, limits that
  /// contradict each other.
  FlirPtu(const FlirPtuConfig& config, const Clock* clock);
  /// Halts the unit.
  ~FlirPtu() override;

  const PanTiltInfo& info() const override { return info_; }
  PanTiltState State() override;
  void Start(const PanTiltAngles& target) override;
  MotionStatus Status() override;
  void Stop() noexcept override;

 private:
  /// How the unit counts.
  struct Scale {
    double pan{};   ///< Radians a count, with the sign that makes left positive.
    double tilt{};  ///< … down.
  };
  struct Motion {
    PanTiltAngles target;
    PanTiltState last;   ///< By which it is told whether it stands still …
    Time progress_at{};  ///< … and when it last did not.
    bool started{};      ///< The unit has been told.
    bool halted{};       ///< … and then to halt.
  };

  void Connect();
  void ReadInfo();
  Scale ReadScale();
  void Run();
  void Turn();
  void HaltWhenAsked();
  void Measure();
  void Judge(const PanTiltState& state);
  void End(const MotionStatus& status);
  void Lose(const std::string& why);

  const FlirPtuConfig config_;
  const Clock* clock_;
  std::unique_ptr<FlirPtuLink> link_;  // of the thread, once that runs
  Scale scale_;
  PanTiltInfo info_;

  std::mutex mutex_;  // of what follows
  std::condition_variable wake_;
  PanTiltState state_;
  MotionStatus status_;
  std::optional<Motion> motion_;
  std::string lost_;  // why; empty: it is not
  bool halt_{};

  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace secondlook::hal
