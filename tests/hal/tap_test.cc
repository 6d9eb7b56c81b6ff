#include "lib/hal/tap.h"

#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/expect_throws.h"
#include "tests/support/fake_robot.h"

namespace secondlook::hal {
namespace {

/// Writes down what it is told.
class Notes : public RobotListener {
 public:
  void OnNow(Time now) override { Add("now {}", ToSeconds(now)); }
  void OnSleep(Time until, Time now) override {
    Add("slept until {}, now {}", ToSeconds(until), ToSeconds(now));
  }
  void OnThinking(Duration cost, Time now) override {
    Add("thought for {}, now {}", ToSeconds(cost), ToSeconds(now));
  }
  void OnBaseState(const BaseState& state) override { Add("base at {}", state.X_WB.x); }
  void OnBaseStart(const BasePath& path) override { Add("base to {}", path.waypoints_W[0].x); }
  void OnBaseStatus(const MotionStatus& status) override {
    Add("base phase {}", static_cast<int>(status.phase));
  }
  void OnHeadState(const PanTiltState& state) override { Add("head at {}", state.angles.pan); }
  void OnHeadStart(const PanTiltAngles& target) override { Add("head to {}", target.pan); }
  void OnHeadStatus(const MotionStatus& status) override {
    Add("head phase {}", static_cast<int>(status.phase));
  }
  void OnFrame(const std::optional<RgbdFrame>& frame, Time now) override {
    Add("frame {}, now {}", frame ? frame->sequence : 0, ToSeconds(now));
  }
  void OnError(Call call, const Error& error, Time now) override {
    Add("call {} at {}: {}", static_cast<int>(call), ToSeconds(now), error.what());
  }

  std::vector<std::string> lines;

 private:
  template <class... Args>
  void Add(fmt::format_string<Args...> format, Args&&... args) {
    lines.push_back(fmt::format(format, std::forward<Args>(args)...));
  }
};

class TapTest : public ::testing::Test {
 protected:
  testing::FakeWorld world_;
  Notes notes_;
  Robot robot_{Tap(testing::MakeFakeRobot(&world_), &notes_)};
};

using Lines = std::vector<std::string>;

TEST_F(TapTest, TellsWhatTheClockSays) {
  robot_.clock->SleepUntil(Time(Seconds(2)));
  robot_.clock->ChargeThinking(Seconds(0.5));
  EXPECT_EQ(robot_.clock->Now(), Time(Seconds(2.5)));
  EXPECT_EQ(notes_.lines, (Lines{"slept until 2, now 2", "thought for 0.5, now 2.5", "now 2.5"}));
}

TEST_F(TapTest, DoesNotTellWhatOtherThreadsAskTheClock) {
  Time now;
  std::thread other([&] { now = robot_.clock->Now(); });
  other.join();
  EXPECT_EQ(now, world_.now);
  EXPECT_EQ(notes_.lines, Lines{});
}

TEST_F(TapTest, TellsStatesPlansAndHowTheyGo) {
  world_.X_WB.x = 1.5;
  world_.base_takes = Seconds(1);
  EXPECT_EQ(robot_.base->State().X_WB.x, 1.5);
  robot_.base->Start({{{3.0, 0.0, 0.0}}});
  EXPECT_EQ(robot_.base->Status().phase, MotionPhase::kMoving);
  robot_.head->Start({0.25, 0.0});
  EXPECT_EQ(robot_.head->Status().phase, MotionPhase::kMoving);
  EXPECT_EQ(robot_.head->State().angles.pan, 0.0);
  EXPECT_EQ(notes_.lines, (Lines{"base at 1.5", "base to 3", "base phase 1", "head to 0.25",
                                 "head phase 1", "head at 0"}));
}

TEST_F(TapTest, TellsFramesAndThatNoneCame) {
  world_.frames.push_back({world_.now, 7, {}, {}});
  EXPECT_TRUE(robot_.head_camera->Grab(Seconds(1)).has_value());
  EXPECT_FALSE(robot_.head_camera->Grab(Seconds(1)).has_value());
  EXPECT_EQ(notes_.lines, (Lines{"frame 7, now 0", "frame 0, now 1"}));
}

TEST_F(TapTest, TellsAnErrorAndPassesItOn) {
  world_.now = Time(Seconds(4));
  world_.base_lost_on_status = true;
  world_.head_lost_on_start = true;
  EXPECT_THROWS(robot_.base->Status(), DeviceError, "base 'wheels': the device is lost");
  EXPECT_THROWS(robot_.head->Start({}), DeviceError, "pan-tilt 'neck': the device is lost");
  EXPECT_EQ(notes_.lines, (Lines{"call 2 at 4: base 'wheels': the device is lost",
                                 "call 4 at 4: pan-tilt 'neck': the device is lost"}));
}

TEST_F(TapTest, PassesStopOnFromAnyThread) {
  robot_.base->Start({{{3.0, 0.0, 0.0}}});
  std::thread other([&] { robot_.Stop(); });
  other.join();
  EXPECT_EQ(world_.base_stops, 1);
  EXPECT_EQ(world_.head_stops, 1);
  EXPECT_EQ(robot_.base->Status().phase, MotionPhase::kStopped);
}

}  // namespace
}  // namespace secondlook::hal
