// Missions that are stopped, go on, are confirmed look by look, and kept in a place.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/make_robot.h"
#include "apps/mission.h"
#include "apps/publisher.h"
#include "apps/run_config.h"
#include "lib/common/parallel.h"
#include "lib/hal/guard.h"
#include "lib/hal/tap.h"
#include "lib/world/object_database.h"
#include "tests/support/small_world.h"

namespace secondlook::apps {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;

/// Counts the motions that reach the devices.
class Motions : public hal::RobotListener {
 public:
  void OnBaseStart(const hal::BasePath& path) override {
    ++count;
    for (const Pose2& waypoint : path.waypoints_W) driven.push_back(waypoint);
  }
  void OnHeadStart(const hal::PanTiltAngles& /*target*/) override { ++count; }

  int count{};
  std::vector<Pose2> driven;
};

/// A mission in a small world that is not stepped yet.
class SafeMission : public ::testing::Test {
 protected:
  SafeMission() {
    ready_.robot = guard_.Protect(hal::Tap(std::move(ready_.robot), &motions_));
    mission_.emplace(
        config_.mission, config_.task, database_, ready_.calibration, config_.seed,
        [this] { return stop_; }, &publisher_, &ready_.robot);
  }

  /// What the executive does at a stop.
  void Stop() {
    stop_ = true;
    guard_.Hold("a test");
    ready_.robot.Stop();
  }

  Progress RunToItsEnd() {
    Progress progress = Progress::kMore;
    for (int i = 0; i < 30 && progress == Progress::kMore; ++i) progress = mission_->Step();
    return progress;
  }

  testing::SmallWorld world_;
  RunConfig config_ = LoadRunConfig(world_.config(), {});
  ThreadLimit threads_{1};
  world::ObjectDatabase database_ = world::ObjectDatabase::Load(config_.models);
  ReadyRobot ready_ = MakeRobot(config_.robot, config_.seed);
  Motions motions_;
  hal::Guard guard_{{}};
  Publisher publisher_;
  bool stop_{};
  std::optional<Mission> mission_;
};

TEST_F(SafeMission, GoesOnAfterAStopThatIsClearedAndSettlesWhatIsThere) {
  ASSERT_EQ(mission_->Step(), Progress::kMore);
  Stop();
  EXPECT_EQ(mission_->Step(), Progress::kStopped);
  EXPECT_EQ(mission_->record().end, "stopped on request");
  const int before = motions_.count;
  stop_ = false;
  guard_.Clear();
  mission_->Resume();
  EXPECT_EQ(mission_->record().end, "");
  EXPECT_EQ(RunToItsEnd(), Progress::kSettled);
  EXPECT_GT(motions_.count, before);
  ASSERT_EQ(mission_->belief().objects.size(), 1U);
  EXPECT_EQ(mission_->belief().objects[0].state, world::ObjectState::kVerified);
}

TEST_F(SafeMission, MovesNothingWhileAStopHoldsEvenWhenItDoesNotAskForIt) {
  guard_.Hold("a test");
  mission_->Step();
  mission_->Step();
  EXPECT_EQ(motions_.count, 0);
  EXPECT_THAT(mission_->record().looks.front().outcome,
              HasSubstr("a protective stop holds: a test"));
}

TEST_F(SafeMission, IsConfirmedLookByLookBeforeAnythingMoves) {
  std::vector<int> motions_before;
  mission_->LetConfirm([&](const world::Look& look) {
    EXPECT_TRUE(look.chosen);
    motions_before.push_back(motions_.count);
  });
  ASSERT_EQ(RunToItsEnd(), Progress::kSettled);
  int taken = 0;
  for (const TakenLook& look : mission_->record().looks) taken += look.look.chosen ? 1 : 0;
  EXPECT_EQ(motions_before.size(), static_cast<std::size_t>(taken));
  EXPECT_EQ(motions_before.front(), 0);
}

TEST_F(SafeMission, DoesNotTakeALookWhenItIsStoppedWhileItWaitsForItsConfirmation) {
  mission_->LetConfirm([&](const world::Look&) { Stop(); });
  EXPECT_EQ(mission_->Step(), Progress::kStopped);
  EXPECT_EQ(motions_.count, 0);
}

TEST_F(SafeMission, TakesNoLookForWhichTheBaseWouldLeaveItsWorkspace) {
  const double x = ready_.robot.base->State().X_WB.x;
  hal::GuardConfig limits;
  limits.workspace = hal::Workspace{{x - 0.4, x + 0.4}, {-3.0, 0.2}};
  mission_->KeepWithin(limits);
  RunToItsEnd();
  for (const Pose2& waypoint : motions_.driven) {
    EXPECT_NEAR(waypoint.x, x, 0.4);
    EXPECT_LE(waypoint.y, 0.2);
  }
  std::vector<std::string> refused;
  for (const TakenLook& taken : mission_->record().looks) {
    for (const world::Look& look : taken.candidates) {
      for (const world::LookCheck& check : look.checks) {
        if (check.name == "workspace") refused.push_back(check.detail);
      }
    }
  }
  EXPECT_FALSE(refused.empty());
  EXPECT_THAT(refused, Each(HasSubstr("out of safety.limits.workspace")));
}

}  // namespace
}  // namespace secondlook::apps
