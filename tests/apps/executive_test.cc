#include "apps/executive.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <future>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/stop_signal.h"
#include "apps/to_message.h"
#include "lib/transport/channels.h"
#include "tests/support/fake_robot.h"

#include "second_look/command_t.hpp"
#include "second_look/look_t.hpp"
#include "second_look/status_t.hpp"

namespace secondlook::apps {
namespace {

namespace channel = transport::channel;
using second_look::command_t;
using second_look::status_t;
using ::testing::StartsWith;

/// Long enough for any machine; what is waited for comes within a second.
constexpr std::chrono::seconds kPatience{60};

/// A base that says when it is stopped.
class StoppedBase : public testing::FakeBase {
 public:
  StoppedBase(testing::FakeWorld* world, std::function<void()> stopped)
      : FakeBase(world), stopped_(std::move(stopped)) {}
  void Stop() noexcept override { stopped_(); }

 private:
  std::function<void()> stopped_;
};

/// An executive on a bus in memory. The thread that makes it is the mission's, and blocked whenever
/// it waits here.
class BlockedMission : public ::testing::Test {
 protected:
  BlockedMission() {
    robot_.base = std::make_unique<StoppedBase>(&world_, [this] {
      if (stops_++ == 0) stopped_.set_value();
    });
    bus_.Listen(channel::kStatus, [this](const transport::Message& message) {
      const std::scoped_lock lock(mutex_);
      statuses_.push_back(transport::Decode<status_t>(message));
      changed_.notify_all();
    });
    bus_.Listen(channel::kLook, [this](const transport::Message& message) {
      const std::scoped_lock lock(mutex_);
      looks_.push_back(message.utime);
      changed_.notify_all();
    });
  }

  void Start(bool takes_tasks = true, const SafetyConfig& safety = {}) {
    executive_.emplace(ExecutiveParts{&bus_, &outbox_, &robot_, &publisher_, &health_,
                                      [] { return "a.log"; }, takes_tasks, &guard_, safety});
  }
  void Start(const SafetyConfig& safety) { Start(true, safety); }
  /// Ends it, and waits for the last that it sends.
  void Finish() {
    executive_.reset();
    bus_.Handle();
  }

  /// Waits until `condition` holds, asked with the mutex locked.
  void WaitUntil(const std::function<bool()>& condition) {
    std::unique_lock lock(mutex_);
    ASSERT_TRUE(changed_.wait_for(lock, kPatience, condition));
  }
  /// The first STATUS for which `condition` holds, from now on or before.
  status_t StatusWhere(const std::function<bool(const status_t&)>& condition) {
    status_t found{};
    WaitUntil([&] {
      for (const status_t& status : statuses_) {
        if (!condition(status)) continue;
        found = status;
        return true;
      }
      return false;
    });
    return found;
  }

  void Bring(const char* channel, std::vector<std::uint8_t> bytes) {
    bus_.Publish({channel, 0, std::move(bytes)});
  }
  void Bring(const command_t& command) { Bring(channel::kCommand, transport::Encode(command)); }
  void Bring(const world::Task& task) { Bring(channel::kTask, transport::Encode(ToMessage(task))); }

  static command_t MakeCommand(int number) {
    command_t command{};
    command.command = static_cast<std::int8_t>(number);
    command.reason = "a test";
    return command;
  }

  testing::FakeWorld world_;
  hal::Guard guard_{{}};
  hal::Robot robot_{testing::MakeFakeRobot(&world_)};
  DeviceHealth health_{robot_};
  Publisher publisher_;
  transport::LcmBus bus_{"memq://"};
  transport::Outbox outbox_{Executive::kOutboxBytes};
  std::atomic<int> stops_{0};
  std::promise<void> stopped_;
  std::mutex mutex_;  // of the three below
  std::condition_variable changed_;
  std::vector<status_t> statuses_;
  std::vector<std::int64_t> looks_;
  std::optional<Executive> executive_;
};

TEST_F(BlockedMission, IsSeenInStatusWithItsPhaseAndDevices) {
  world_.now = Time(Seconds(12.5));
  health_.OnHeadState({Time(Seconds(12)), {}});
  publisher_.BeginStep();
  publisher_.Doing("choosing", "3 objects are open", Time(Seconds(12)));
  Start();
  const status_t status = StatusWhere([](const status_t& s) { return s.sent > 1; });
  EXPECT_EQ(status.phase, "choosing");
  EXPECT_EQ(status.detail, "3 objects are open");
  EXPECT_EQ(status.step, 1);
  EXPECT_EQ(status.robot_utime, 12'500'000);
  EXPECT_GT(status.utime, 1'700'000'000'000'000) << "microseconds since 1970";
  ASSERT_EQ(status.devices.size(), 3U);
  EXPECT_EQ(status.devices[1].name, "neck");
  EXPECT_EQ(status.devices[1].health, second_look::device_status_t::OK);
  EXPECT_EQ(status.recording, "a.log");
  EXPECT_EQ(stops_, 0);
  EXPECT_FALSE(executive_->StopRequested());
}

TEST_F(BlockedMission, IsStoppedByACommand) {
  Start();
  Bring(MakeCommand(command_t::STOP));
  ASSERT_EQ(stopped_.get_future().wait_for(kPatience), std::future_status::ready);
  EXPECT_TRUE(executive_->StopRequested());
}

TEST_F(BlockedMission, IsHeldByTheGuardAfterAStop) {
  Start();
  Bring(MakeCommand(command_t::STOP));
  ASSERT_EQ(stopped_.get_future().wait_for(kPatience), std::future_status::ready);
  EXPECT_TRUE(guard_.holds());
  EXPECT_EQ(guard_.why(), "a command: 'a test'");
}

TEST_F(BlockedMission, ThatWaitsAfterAStopGoesOnOnceItIsCleared) {
  SafetyConfig safety;
  safety.wait_after_stop = true;
  Start(safety);
  Bring(MakeCommand(command_t::STOP));
  ASSERT_EQ(stopped_.get_future().wait_for(kPatience), std::future_status::ready);
  Bring(MakeCommand(command_t::ALIVE));
  EXPECT_TRUE(executive_->StopRequested()) << "nothing but CLEAR clears it";
  Bring(MakeCommand(command_t::CLEAR));
  EXPECT_TRUE(executive_->WaitUntilCleared());
  EXPECT_FALSE(executive_->StopRequested());
  EXPECT_FALSE(guard_.holds());
}

TEST_F(BlockedMission, IsNotClearedWhereAStopEndsTheMission) {
  Start();
  Bring(MakeCommand(command_t::STOP));
  Bring(MakeCommand(command_t::CLEAR));
  const status_t status = StatusWhere([](const status_t& s) { return s.rejected > 0; });
  EXPECT_EQ(status.last_rejected,
            "SECONDLOOK_COMMAND: a stop ends the mission; nothing is to be cleared");
  EXPECT_TRUE(executive_->StopRequested());
  EXPECT_TRUE(guard_.holds());
}

TEST_F(BlockedMission, StopsWhenTheHeartbeatOfItsCommanderIsLost) {
  SafetyConfig safety;
  safety.heartbeat_seconds = 0.1;
  Start(safety);
  Bring(MakeCommand(command_t::ALIVE));
  ASSERT_EQ(stopped_.get_future().wait_for(kPatience), std::future_status::ready);
  EXPECT_THAT(guard_.why(), StartsWith("the lost heartbeat of its commander: nothing on "
                                       "SECONDLOOK_COMMAND for 0."));
  EXPECT_TRUE(executive_->StopRequested());
}

TEST_F(BlockedMission, StopsAMotionThatItNoLongerAsksAbout) {
  robot_ = guard_.Protect(std::move(robot_));
  world_.head_takes = Seconds(60.0);
  robot_.head->Start({0.5, 0.0});
  robot_.head->Status();
  world_.now += Seconds(2.5);  // safety.limits.lapse_seconds is 2
  Start();
  ASSERT_EQ(stopped_.get_future().wait_for(kPatience), std::future_status::ready);
  EXPECT_THAT(guard_.why(), StartsWith("pan-tilt 'neck': it moves, and for 2 s the mission has "
                                       "not asked how far it is"));
}

TEST_F(BlockedMission, WaitsUntilALookIsConfirmed) {
  SafetyConfig safety;
  safety.confirm = true;
  Start(safety);
  Bring(MakeCommand(command_t::CONFIRM));  // too early
  StatusWhere([](const status_t& s) {
    return s.last_rejected == "SECONDLOOK_COMMAND: no look waits for a confirmation";
  });
  auto confirmed = std::async(std::launch::async, [&] { executive_->WaitForConfirmation(); });
  while (confirmed.wait_for(std::chrono::milliseconds(5)) != std::future_status::ready) {
    Bring(MakeCommand(command_t::CONFIRM));
  }
  EXPECT_FALSE(executive_->StopRequested());
}

TEST_F(BlockedMission, IsStoppedWhileItWaitsForAConfirmation) {
  SafetyConfig safety;
  safety.confirm = true;
  Start(safety);
  Bring(MakeCommand(command_t::STOP));
  executive_->WaitForConfirmation();
  EXPECT_TRUE(executive_->StopRequested());
}

TEST_F(BlockedMission, TakesNoCommandButStopFromWhereNoneIsTaken) {
  SafetyConfig safety;
  safety.wait_after_stop = true;
  Start(false, safety);
  Bring(MakeCommand(command_t::STOP));
  Bring(MakeCommand(command_t::CLEAR));
  const status_t status = StatusWhere([](const status_t& s) { return s.rejected > 0; });
  EXPECT_THAT(status.last_rejected, ::testing::HasSubstr("no command but STOP is taken from "
                                                         "beyond this host"));
  EXPECT_TRUE(guard_.holds());
}

TEST(SafetyConfig, NamesAHeartbeatThatIsTooFast) {
  SafetyConfig config;
  EXPECT_NO_THROW(config.Validate());
  config.heartbeat_seconds = 0.01;
  EXPECT_THAT([&] { config.Validate(); },
              ::testing::ThrowsMessage<ConfigError>(
                  ::testing::HasSubstr("heartbeat_seconds (0: none) = 0.01 must lie in 0.1..60")));
}

TEST_F(BlockedMission, IsStoppedByASignal) {
  // In a process of its own: a signal asks all that follows in this one to stop, too.
  const auto raise_and_wait = [this] {
    CatchStopSignals();
    Start();
    std::raise(SIGTERM);
    stopped_.get_future().wait();
    std::_Exit(executive_->StopRequested() ? EXIT_SUCCESS : EXIT_FAILURE);
  };
  EXPECT_EXIT(raise_and_wait(), ::testing::ExitedWithCode(EXIT_SUCCESS), "");
}

TEST_F(BlockedMission, IsNotStoppedByACommandThatThereIsNot) {
  Start();
  Bring(MakeCommand(7));
  const status_t status = StatusWhere([](const status_t& s) { return s.rejected > 0; });
  EXPECT_EQ(status.last_rejected, "SECONDLOOK_COMMAND: there is no command 7");
  EXPECT_EQ(stops_, 0);
  EXPECT_FALSE(executive_->StopRequested());
}

TEST_F(BlockedMission, GetsTheTaskThatCameInLast) {
  Start();
  world::Task task;
  task.wanted["mug"] = 0.99;
  Bring(task);
  task.wanted["mug"] = 0.95;
  task.budget.looks = 3;
  Bring(task);
  const status_t status = StatusWhere([](const status_t& s) { return s.receive_drops > 0; });
  EXPECT_EQ(status.receive_drops, 1);
  const std::optional<world::Task> taken = executive_->TakeTask();
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->wanted.at("mug"), 0.95);
  EXPECT_EQ(taken->budget.looks, 3);
  EXPECT_FALSE(executive_->TakeTask()) << "only once";
}

TEST_F(BlockedMission, NeverGetsATaskThatIsNotValid) {
  Start();
  world::Task task;
  task.confidence = 1.5;
  Bring(task);
  task.confidence = std::numeric_limits<double>::quiet_NaN();
  Bring(task);
  const status_t status = StatusWhere([](const status_t& s) { return s.rejected >= 2; });
  EXPECT_EQ(status.last_rejected,
            "SECONDLOOK_TASK: second_look.task_t: 'confidence' is not finite");
  EXPECT_FALSE(executive_->TakeTask());
}

TEST_F(BlockedMission, TakesAStopButNoTaskFromWhereNoneIsTaken) {
  Start(false);
  Bring(world::Task{});
  const status_t status = StatusWhere([](const status_t& s) { return s.rejected > 0; });
  EXPECT_THAT(status.last_rejected, ::testing::HasSubstr("no task is taken from beyond this host"));
  EXPECT_FALSE(executive_->TakeTask());
  Bring(MakeCommand(command_t::STOP));
  stopped_.get_future().wait();
  EXPECT_TRUE(executive_->StopRequested());
}

TEST_F(BlockedMission, SaysInStatusWhyItDoesNotDoATask) {
  Start();
  executive_->RejectTask("'cup' is not in the object database");
  const status_t status = StatusWhere([](const status_t& s) { return s.rejected > 0; });
  EXPECT_EQ(status.last_rejected, "SECONDLOOK_TASK: 'cup' is not in the object database");
}

TEST_F(BlockedMission, ActsOnNoGarbageOnAnyChannelAndCountsItAll) {
  Start();
  std::int64_t brought = 0;
  const std::vector<std::uint8_t> stop = transport::Encode(MakeCommand(command_t::STOP));
  const std::vector<std::uint8_t> task = transport::Encode(ToMessage(world::Task{}));
  for (const auto& [channel, own, other] :
       {std::tuple{channel::kCommand, stop, task}, std::tuple{channel::kTask, task, stop}}) {
    std::vector<std::uint8_t> too_long = own;
    too_long.resize(300'000);
    std::vector<std::uint8_t> huge_count = own;
    huge_count[16] = 0x7f;  // of the command its code, of the task how many are wanted
    for (const auto& bytes :
         {std::vector<std::uint8_t>{}, std::vector<std::uint8_t>(1'000, 0xff), other, too_long,
          huge_count, std::vector<std::uint8_t>(own.begin(), own.end() - 3)}) {
      Bring(channel, bytes);
      ++brought;
    }
  }
  const status_t status = StatusWhere([&](const status_t& s) { return s.rejected >= brought; });
  EXPECT_EQ(status.rejected, brought);
  EXPECT_GE(status.received, brought);
  EXPECT_THAT(status.last_rejected, StartsWith("SECONDLOOK_TASK: second_look.task_t: cut off"));
  EXPECT_EQ(stops_, 0);
  EXPECT_FALSE(executive_->StopRequested());
  EXPECT_FALSE(executive_->TakeTask());
}

TEST_F(BlockedMission, HasWhatItToldSentInOrder) {
  Start();
  for (int i = 1; i <= 20; ++i) {
    second_look::look_t look{};
    look.utime = i;
    outbox_.Post(transport::Pack(channel::kLook, look));
  }
  WaitUntil([this] { return looks_.size() == 20; });
  for (int i = 1; i <= 20; ++i) EXPECT_EQ(looks_[i - 1], i);
}

TEST_F(BlockedMission, HasAllSentAndALastStatusAtItsEnd) {
  Start();
  second_look::look_t look{};
  for (int i = 0; i < 20; ++i) outbox_.Post(transport::Pack(channel::kLook, look));
  publisher_.Doing("ended", "everything is settled", Time{});
  Finish();
  EXPECT_EQ(looks_.size(), 20U);
  ASSERT_FALSE(statuses_.empty());
  EXPECT_EQ(statuses_.back().phase, "ended");
  EXPECT_EQ(statuses_.back().sent, std::ssize(looks_) + std::ssize(statuses_));
  EXPECT_EQ(statuses_.back().send_drops, 0);
}

TEST_F(BlockedMission, SaysHowManyMessagesHadNoRoom) {
  std::vector<std::uint8_t> bytes(Executive::kOutboxBytes / 2);
  for (int i = 0; i < 5; ++i) outbox_.Post({channel::kImage, 0, bytes});
  while (outbox_.Take()) {
  }
  Start();
  const status_t status = StatusWhere([](const status_t& s) { return s.sent > 0; });
  EXPECT_EQ(status.send_drops, 3);
}

TEST(Executive, NeedsNoBusToEnd) {
  testing::FakeWorld world;
  hal::Robot robot = testing::MakeFakeRobot(&world);
  const DeviceHealth health(robot);
  const Publisher publisher;
  transport::Outbox outbox(1'000);
  Executive executive({nullptr, &outbox, &robot, &publisher, &health, {}});
  EXPECT_FALSE(executive.StopRequested());
  EXPECT_FALSE(executive.TakeTask());
}

}  // namespace
}  // namespace secondlook::apps
