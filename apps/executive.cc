#include "apps/executive.h"

#include <poll.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <exception>
#include <utility>

#include <spdlog/spdlog.h>

#include "apps/stop_signal.h"
#include "apps/to_message.h"
#include "lib/common/error.h"
#include "lib/common/service_manager.h"
#include "lib/transport/channels.h"

#include "second_look/command_t.hpp"
#include "second_look/status_t.hpp"

namespace secondlook::apps {
namespace {

namespace channel = transport::channel;
using std::chrono::duration;
using std::chrono::duration_cast;
using std::chrono::milliseconds;
using std::chrono::steady_clock;
using std::chrono::system_clock;

/// Nothing wakes the thread for a signal or a new message to send: it looks this often.
constexpr milliseconds kTick{10};
constexpr milliseconds kStatusPeriod{500};
constexpr milliseconds kMaxDrain{5'000};
/// A service manager that watches for less than three times as long is told too seldom.
constexpr milliseconds kSignOfLife{500};
/// A default socket buffer holds one of our largest messages, so a listener has 100 ms to take it …
constexpr double kBytesPerSecond = 1e6;
/// … and 1 ms for the smallest, as what it queues is counted in messages.
constexpr std::size_t kLeastBytes = 1'000;

/// Puts this thread ahead of all that computes, where the system lets us.
void GoAhead() {
  sched_param parameters{};
  parameters.sched_priority = sched_get_priority_min(SCHED_RR);
  pthread_setschedparam(pthread_self(), SCHED_RR, &parameters);
}

steady_clock::duration PauseAfter(const transport::Message& message) {
  const auto bytes = static_cast<double>(std::max(message.bytes.size(), kLeastBytes));
  return duration_cast<steady_clock::duration>(duration<double>(bytes / kBytesPerSecond));
}

std::int64_t WallUtime() {
  return duration_cast<std::chrono::microseconds>(system_clock::now().time_since_epoch()).count();
}

}  // namespace

Executive::Executive(const ExecutiveParts& parts) : parts_(parts) {
  if (parts_.bus != nullptr) Listen();
  thread_ = std::thread([this] { Run(); });
}

Executive::~Executive() {
  finishing_ = true;
  thread_.join();
}

bool Executive::StopRequested() const { return stop_requested_ || StopSignal() != 0; }

std::optional<world::Task> Executive::TakeTask() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(task_, std::nullopt);
}

bool Executive::WaitUntilCleared() {
  while (stop_requested_ && !stopped_for_good_) std::this_thread::sleep_for(kTick);
  return !StopRequested();
}

void Executive::WaitForConfirmation() {
  wants_confirmation_ = true;
  while (wants_confirmation_ && !StopRequested()) std::this_thread::sleep_for(kTick);
  wants_confirmation_ = false;
}

void Executive::RejectTask(const std::string& why) const {
  parts_.bus->Reject(channel::kTask, why);
}

void Executive::Listen() {
  parts_.bus->Listen(channel::kCommand, [this](const transport::Message& message) {
    const auto command = transport::Decode<second_look::command_t>(message);
    Command(command.command, command.reason);
  });
  parts_.bus->Listen(channel::kTask, [this](const transport::Message& message) {
    if (!parts_.takes_tasks) {
      Throw<ProtocolError>("no task is taken from beyond this host; --remote-tasks allows it");
    }
    world::Task task = FromMessage(transport::Decode<second_look::task_t>(message));
    task.Validate();
    const std::scoped_lock lock(mutex_);
    if (task_) ++replaced_tasks_;
    task_ = std::move(task);
  });
  if (!parts_.bus->unreachable().empty()) {
    spdlog::warn("nobody outside can listen or speak to this mission, which goes on without: {}",
                 parts_.bus->unreachable());
  }
}

void Executive::Command(int command, const std::string& reason) {
  using second_look::command_t;
  if (command != command_t::STOP && !parts_.takes_tasks) {
    Throw<ProtocolError>(
        "no command but STOP is taken from beyond this host; --remote-tasks "
        "allows it");
  }
  commander_heard_ = steady_clock::now();  // whatever it wants
  switch (command) {
    case command_t::STOP:
      Stop(fmt::format("a command: '{}'", reason), false);
      return;
    case command_t::CLEAR:
      if (!parts_.safety.wait_after_stop) {
        Throw<ProtocolError>("a stop ends the mission; nothing is to be cleared");
      }
      if (!stop_requested_) Throw<ProtocolError>("there is no stop to be cleared");
      if (stopped_for_good_) Throw<ProtocolError>("this stop is for good; start a new mission");
      if (parts_.guard != nullptr) parts_.guard->Clear();
      stop_requested_ = false;
      spdlog::warn("the stop is cleared by a command: '{}'", reason);
      return;
    case command_t::ALIVE:
      return;
    case command_t::CONFIRM:
      if (!wants_confirmation_.exchange(false)) {
        Throw<ProtocolError>("no look waits for a confirmation");
      }
      return;
    default:
      Throw<ProtocolError>("there is no command {}", command);
  }
}

/// A fault of this thread must not leave a robot that moves and that nobody can stop.
void Executive::Run() try { Work(); } catch (const std::exception& error) {
  Stop(fmt::format("a fault of the program: {}", error.what()), true);
}

void Executive::Work() {
  GoAhead();
  next_status_ = steady_clock::now();
  commander_heard_ = next_status_;
  TellServiceManager(true);
  std::optional<WallTime> deadline;
  while (true) {
    if (finishing_ && !deadline) deadline = steady_clock::now() + kMaxDrain;
    if (deadline && (parts_.outbox->Empty() || steady_clock::now() >= *deadline)) break;
    Wait();
    StopOnSignal();
    StopOnLapse();
    if (steady_clock::now() >= next_sign_of_life_) TellServiceManager(false);
    if (parts_.bus == nullptr) continue;
    parts_.bus->Handle();
    StopOnSilence();
    WarnOfRejection();
    if (steady_clock::now() >= next_send_) SendNext();
    if (steady_clock::now() >= next_status_) SendStatus();
  }
  if (parts_.bus != nullptr) SendStatus();
  NotifyServiceManager("STOPPING=1");
}

/// Until there is something to do, a tick at most.
void Executive::Wait() const {
  pollfd in{-1, POLLIN, 0};  // which poll() leaves out
  WallTime until = steady_clock::now() + kTick;
  if (parts_.bus != nullptr) {
    in.fd = parts_.bus->fileno();
    until = std::min(until, next_status_);
    if (!parts_.outbox->Empty()) until = std::min(until, next_send_);
  }
  const auto left = std::chrono::ceil<milliseconds>(until - steady_clock::now());
  poll(&in, 1, static_cast<int>(std::max(left.count(), milliseconds::rep{0})));
}

void Executive::StopOnSignal() {
  if (signal_seen_ || StopSignal() == 0) return;
  signal_seen_ = true;
  Stop(fmt::format("signal {}", StopSignal()), true);
}

void Executive::StopOnLapse() {
  if (parts_.guard == nullptr || stop_requested_) return;
  const std::string device = parts_.guard->Lapsed();
  if (device.empty()) return;
  Stop(fmt::format("{}: it moves, and for {} s the mission has not asked how far it is", device,
                   parts_.guard->config().lapse_seconds),
       true);
}

void Executive::StopOnSilence() {
  if (parts_.safety.heartbeat_seconds == 0.0 || stop_requested_) return;
  const duration<double> silent = steady_clock::now() - commander_heard_;
  if (silent.count() <= parts_.safety.heartbeat_seconds) return;
  Stop(fmt::format("the lost heartbeat of its commander: nothing on {} for {:.1f} s, "
                   "safety.heartbeat_seconds is {}",
                   channel::kCommand, silent.count(), parts_.safety.heartbeat_seconds),
       false);
}

/// @param for_good No command can clear it.
void Executive::Stop(const std::string& why, bool for_good) {
  if (for_good) stopped_for_good_ = true;
  stop_requested_ = true;  // first, so that the mission starts nothing anew
  if (parts_.guard != nullptr) parts_.guard->Hold(why);
  parts_.robot->Stop();
  spdlog::warn("the robot is stopped by {}", why);
}

void Executive::TellServiceManager(bool ready) {
  next_sign_of_life_ = steady_clock::now() + kSignOfLife;
  const Activity activity = parts_.publisher->activity();
  NotifyServiceManager(fmt::format("{}WATCHDOG=1\nSTATUS={}: {}", ready ? "READY=1\n" : "",
                                   activity.phase, activity.detail));
}

void Executive::SendNext() {
  const std::optional<transport::Message> message = parts_.outbox->Take();
  if (!message) return;
  parts_.bus->Publish(*message);
  next_send_ = steady_clock::now() + PauseAfter(*message);
}

void Executive::SendStatus() {
  next_status_ = std::max(next_status_ + kStatusPeriod, steady_clock::now());
  const Activity activity = parts_.publisher->activity();
  const Time now = parts_.robot->clock->Now();
  const transport::BusCounts counts = parts_.bus->counts();
  second_look::status_t status{};
  status.utime = WallUtime();
  status.phase = activity.phase;
  status.detail = activity.detail;
  status.step = activity.step;
  status.robot_utime = ToUtime(now);
  status.devices = parts_.health->Status(now);
  status.num_devices = static_cast<std::int32_t>(status.devices.size());
  status.sent = counts.sent + 1;  // this one, too
  status.send_drops = parts_.outbox->drops() + counts.send_failures;
  status.received = counts.received;
  status.rejected = counts.rejected;
  status.last_rejected = counts.last_rejected;
  {
    const std::scoped_lock lock(mutex_);
    status.receive_drops = replaced_tasks_;
  }
  if (parts_.recording) status.recording = parts_.recording();
  parts_.bus->Publish(transport::Pack(channel::kStatus, status));
}

/// Of the first; the others are counted in STATUS.
void Executive::WarnOfRejection() {
  if (warned_of_rejection_) return;
  const transport::BusCounts counts = parts_.bus->counts();
  if (counts.rejected == 0) return;
  warned_of_rejection_ = true;
  spdlog::warn("a message is rejected, {}; STATUS counts any further ones", counts.last_rejected);
}

}  // namespace secondlook::apps
