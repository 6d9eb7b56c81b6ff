#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>

#include "lib/common/clock.h"
#include "lib/hal/pan_tilt.h"

namespace secondlook::hal {

/// A clock that runs only while SleepUntil() waits, and there in small steps, after each of which
/// the other side of the wire is heard: so a test depends neither on the speed of the machine nor
/// on how its threads take turns.
class SteppedClock : public Clock {
 public:
  Time Now() const override;
  void SleepUntil(Time time) override;
  void ChargeThinking(Duration) override {}

  /// Called by the other side whenever it was heard.
  void Heard();
  /// False: nobody is heard, so nothing is waited for.
  void WaitForOther(bool wait);

 private:
  mutable std::mutex mutex_;
  std::condition_variable heard_;
  Time now_{};
  long count_{};
  bool wait_{true};
};

/// What goes wrong at a pan-tilt unit.
enum class PtuFault {
  kNone,
  kSilent,     ///< It answers nothing.
  kGarbage,    ///< Noise before each answer; some answers are noise altogether.
  kTalks,      ///< Another device is at the port, which talks all the time.
  kStuck,      ///< It acknowledges, and does not move.
  kUnplugged,  ///< Its port is gone. kNone plugs it in again, powered up anew.
};

/// A FLIR PTU-D46 at a pseudo-terminal, with the figures of its data sheet. It powers up as the
/// real one does: a banner, echo on, long answers, at its zero.
class PtuEmulator {
 public:
  /// @param clock By which it moves. @param folder Where its port appears, as a link.
  PtuEmulator(SteppedClock* clock, const std::filesystem::path& folder)
      : PtuEmulator(clock, clock, folder) {}
  /// Likewise, by a clock that waits for nobody.
  PtuEmulator(const Clock* clock, const std::filesystem::path& folder)
      : PtuEmulator(clock, nullptr, folder) {}
  ~PtuEmulator();

  std::string port() const { return port_.string(); }
  void Set(PtuFault fault);
  /// What it was told last that was no question, e.g. "pp-500", "h".
  std::string last_command() const;

  /// Where it was told to go.
  PanTiltAngles target() const;
  /// It is at `angles` now, and moves no more by itself.
  void Place(const PanTiltAngles& angles);

 private:
  PtuEmulator(const Clock* clock, SteppedClock* stepped, const std::filesystem::path& folder);

  struct Axis {
    double position{};
    double target{};
    double speed{1000};
    double lower{}, upper{};
  };

  void PlugIn();
  void Unplug();
  void Run();
  void Move();
  std::string Answer(const std::string& command);
  std::string Number(const std::string& words, double value) const;
  Axis* AxisOf(char name) { return name == 'p' ? &pan_ : name == 't' ? &tilt_ : nullptr; }

  const Clock* clock_;
  SteppedClock* stepped_;  // null: nobody waits for what is heard
  std::filesystem::path port_;
  mutable std::mutex mutex_;
  int master_{-1};
  PtuFault fault_{PtuFault::kNone};
  bool echo_{true};
  bool terse_{};
  int answers_{};
  Axis pan_{0, 0, 1000, -3090, 3090};  // +-159 deg at 185.1428 arc seconds
  Axis tilt_{0, 0, 1000, -907, 604};   // -46.6 to 31 deg
  Time moved_at_{};
  bool placed_{};
  std::string last_command_;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace secondlook::hal
