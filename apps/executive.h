#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "apps/device_health.h"
#include "apps/publisher.h"
#include "apps/safety_config.h"
#include "lib/hal/guard.h"
#include "lib/hal/robot.h"
#include "lib/transport/lcm_bus.h"
#include "lib/transport/outbox.h"
#include "lib/world/task.h"

namespace secondlook::apps {

/// What the executive works with. All of it must outlive the executive.
struct ExecutiveParts {
  transport::LcmBus* bus{};      ///< Null: nothing comes in or goes out, and signals alone stop.
  transport::Outbox* outbox{};   ///< What is to be sent.
  hal::Robot* robot{};           ///< To be stopped; otherwise only its clock is read.
  const Publisher* publisher{};  ///< What the mission is doing.
  const DeviceHealth* health{};  ///< How its devices are.
  std::function<std::string()> recording{};  ///< As status_t has it; may be empty.
  bool takes_tasks{true};                    ///< Over the bus; stops are always taken.
  hal::Guard* guard{};    ///< That `robot` is behind, to hold it after a stop; null: none.
  SafetyConfig safety{};  ///< Of its `limits` the guard knows.
};

/// The thread that must never wait, so that the robot can be seen and stopped while the mission
/// thinks for seconds. It
/// - sends what is in the outbox, at a pace that default socket buffers can follow;
/// - sends STATUS at 2 Hz of wall time;
/// - on SECONDLOOK_COMMAND STOP, on SIGINT, SIGTERM or SIGHUP, when the commander's heartbeat is
///   lost, when a motion lapses and when it fails itself, makes the robot stand still at once,
///   holds it there and asks the mission to end;
/// - tells the service manager that the process is ready, and that it lives;
/// - keeps the task that came in last for the mission to take, between two steps.
/// Threading: all functions from one thread, the mission's.
class Executive {
 public:
  /// Waiting messages beyond this are dropped, see Outbox [bytes].
  static constexpr std::size_t kOutboxBytes = 4'000'000;

  /// Begins. A bus that is unreachable is warned of, once.
  explicit Executive(const ExecutiveParts& parts);
  /// Sends what still waits, for a few seconds at most, and a last STATUS.
  ~Executive();
  Executive(const Executive&) = delete;
  Executive& operator=(const Executive&) = delete;

  /// True once a signal or a command has asked for a stop.
  bool StopRequested() const;

  /// Waits until a command clears the stop. False when something else has stopped the robot, or
  /// does so meanwhile: then it is for good.
  bool WaitUntilCleared();

  /// Waits until somebody confirms the look that was told last, or the robot is stopped.
  void WaitForConfirmation();

  /// The task that came in last, once.
  std::optional<world::Task> TakeTask();

  /// Says in STATUS why a task that was taken is not done.
  void RejectTask(const std::string& why) const;

 private:
  using WallTime = std::chrono::steady_clock::time_point;

  void Listen();
  void Run();
  void Wait() const;
  void Work();
  void StopOnSignal();
  void StopOnSilence();
  void StopOnLapse();
  void Command(int command, const std::string& reason);
  void Stop(const std::string& why, bool for_good);
  void TellServiceManager(bool ready);
  void SendNext();
  void SendStatus();
  void WarnOfRejection();

  ExecutiveParts parts_;
  WallTime next_send_{};
  WallTime next_status_{};
  WallTime next_sign_of_life_{};
  WallTime commander_heard_{};
  bool signal_seen_{};
  bool warned_of_rejection_{};
  std::atomic<bool> stop_requested_{false};
  std::atomic<bool> stopped_for_good_{false};  // by anything but a command
  std::atomic<bool> wants_confirmation_{false};
  std::atomic<bool> finishing_{false};
  mutable std::mutex mutex_;  // of the two below
  std::optional<world::Task> task_;
  std::int64_t replaced_tasks_{};
  std::thread thread_;  // the last: it uses all the others
};

}  // namespace secondlook::apps
