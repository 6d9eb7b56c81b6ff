#include "apps/drive.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"
#include "tests/support/fake_robot.h"

namespace secondlook::apps {
namespace {

using hal::MotionPhase;
using Kind = DriveOutcome::Kind;

class Drive : public ::testing::Test {
 protected:
  Drive() : robot_(testing::MakeFakeRobot(&world_)) {
    look_.path_W = {{1.0, 0.0, 0.0}};
    look_.head = {0.3, 0.2};
    look_.seconds = 4.0;
    world_.base_takes = Seconds(2.0);
    world_.base_speed = 0.5;
    world_.head_takes = Seconds(1.0);
  }

  DriveOutcome Move(const StopRequest& stop = [] { return false; }) {
    return MoveTo(
        look_, stop, [this](double metres) { told_metres_.push_back(metres); }, &robot_,
        &capturer_);
  }

  testing::FakeWorld world_;
  hal::Robot robot_;
  Capturer capturer_{&robot_, kinematics::HeadCalibration::AtHeight(1.0)};
  world::Look look_;
  std::vector<double> told_metres_;
};

TEST_F(Drive, MovesTheBaseThenTheHeadAndWaitsForBoth) {
  world_.base_speed = 0.5;
  const DriveOutcome outcome = Move();
  EXPECT_EQ(outcome.kind, Kind::kReached);
  EXPECT_EQ(outcome.reason, "");
  EXPECT_NEAR(outcome.metres, 1.0, 1e-9);  // 2 s at 0.5 m/s
  EXPECT_EQ(world_.head_started, world_.base_started + Seconds(2.0));
  EXPECT_EQ(world_.angles, look_.head);
  EXPECT_EQ(world_.now, Time(Seconds(3.0)));
}

TEST_F(Drive, TellsHowFarItIsOnTheWay) {
  world_.base_speed = 0.5;
  Move();
  ASSERT_FALSE(told_metres_.empty());
  EXPECT_TRUE(std::is_sorted(told_metres_.begin(), told_metres_.end()));
  EXPECT_NEAR(told_metres_.back(), 1.0, 1e-9) << "the head moves last, the way is done by then";
}

TEST_F(Drive, LeavesTheBaseAloneWithoutAPath) {
  look_.path_W.clear();
  EXPECT_EQ(Move().kind, Kind::kReached);
  EXPECT_EQ(world_.base_starts, 0);
  EXPECT_EQ(world_.head_starts, 1);
}

TEST_F(Drive, SaysWhyTheBaseFailedAndLeavesTheHeadAlone) {
  world_.base_ends = {MotionPhase::kFailed, "blocked after 0.4 m"};
  const DriveOutcome outcome = Move();
  EXPECT_EQ(outcome.kind, Kind::kFailed);
  EXPECT_EQ(outcome.reason, "wheels: blocked after 0.4 m");
  EXPECT_TRUE(outcome.base_failed);
  EXPECT_EQ(world_.head_starts, 0);
}

TEST_F(Drive, SaysWhyTheHeadFailedAndCountsWhatWasDriven) {
  world_.base_speed = 0.5;
  world_.head_ends = {MotionPhase::kFailed, "stalled at 0.1 rad"};
  const DriveOutcome outcome = Move();
  EXPECT_EQ(outcome.kind, Kind::kFailed);
  EXPECT_EQ(outcome.reason, "neck: stalled at 0.1 rad");
  EXPECT_FALSE(outcome.base_failed) << "so nothing is taken to stand in its way";
  EXPECT_NEAR(outcome.metres, 1.0, 1e-9);
}

TEST_F(Drive, TakesAStopBySomebodyElseForAFailure) {
  world_.base_ends = {MotionPhase::kStopped, ""};
  const DriveOutcome outcome = Move();
  EXPECT_EQ(outcome.kind, Kind::kFailed);
  EXPECT_EQ(outcome.reason, "wheels: stopped");
}

TEST_F(Drive, StopsEverythingWhenAMotionTakesThreeTimesAsLongAsPlannedPlusFifteenSeconds) {
  world_.base_takes = Seconds(1e6);
  const DriveOutcome outcome = Move();
  EXPECT_EQ(outcome.kind, Kind::kFailed);
  EXPECT_EQ(outcome.reason, "wheels: still moving after 27.0 s");  // 3 * 4 + 15
  EXPECT_NEAR(ToSeconds(world_.now), 27.0, 0.06);
  EXPECT_EQ(world_.base_status.phase, MotionPhase::kStopped);
  EXPECT_EQ(world_.base_stops, 1);
  EXPECT_EQ(world_.head_stops, 1);
}

TEST_F(Drive, StopsEverythingWithinOnePollOfARequest) {
  const DriveOutcome outcome = Move([&] { return world_.now >= Time(Seconds(1.0)); });
  EXPECT_EQ(outcome.kind, Kind::kStopped);
  EXPECT_EQ(outcome.reason, "wheels: stopped on request");
  EXPECT_LE(world_.now, Time(Seconds(1.06)));
  EXPECT_EQ(world_.base_status.phase, MotionPhase::kStopped);
  EXPECT_EQ(world_.head_starts, 0);
}

TEST_F(Drive, StopsTheHeadOnRequest) {
  const DriveOutcome outcome = Move([&] { return world_.now >= Time(Seconds(2.5)); });
  EXPECT_EQ(outcome.kind, Kind::kStopped);
  EXPECT_EQ(outcome.reason, "neck: stopped on request");
  EXPECT_EQ(world_.head_status.phase, MotionPhase::kStopped);
}

TEST_F(Drive, StartsNothingOnceItIsAskedToStop) {
  const DriveOutcome outcome = Move([] { return true; });
  EXPECT_EQ(outcome.kind, Kind::kStopped);
  EXPECT_EQ(world_.base_starts, 0);
  EXPECT_EQ(world_.head_starts, 0);
}

TEST_F(Drive, KnowsItsOwnRequestWhenTheBaseWasStoppedForItAlready) {
  world_.base_takes = Seconds(1.0);
  world_.base_ends = {MotionPhase::kStopped, ""};
  const DriveOutcome outcome = Move([&] { return world_.now >= Time(Seconds(1.0)); });
  EXPECT_EQ(outcome.kind, Kind::kStopped);
  EXPECT_EQ(outcome.reason, "wheels: stopped on request");
}

TEST_F(Drive, StopsEverythingWhenTheBaseIsLost) {
  world_.base_lost_on_status = true;
  EXPECT_THROWS(Move(), DeviceError, "base 'wheels': the device is lost");
  EXPECT_EQ(world_.base_stops, 1);
  EXPECT_EQ(world_.head_stops, 1);
}

TEST_F(Drive, StopsEverythingWhenTheHeadIsLost) {
  world_.head_lost_on_start = true;
  EXPECT_THROWS(Move(), DeviceError, "pan-tilt 'neck': the device is lost");
  EXPECT_EQ(world_.base_stops, 1);
  EXPECT_EQ(world_.head_stops, 1);
}

TEST_F(Drive, DoesNotBelieveABaseThatIsNotWhereItSaysItHasGotTo) {
  world_.base_speed = 0.35;  // 0.7 m of 1 m
  const DriveOutcome outcome = Move();
  EXPECT_EQ(outcome.kind, Kind::kFailed);
  EXPECT_EQ(outcome.reason,
            "wheels: says it has reached its goal, but localisation sees it 0.30 m and 0.0 deg "
            "away");
  EXPECT_FALSE(outcome.base_failed) << "nothing was in the way";
  EXPECT_EQ(world_.head_starts, 0);
}

TEST_F(Drive, GivesUpOnAHeadThatDoesNotAnswer) {
  world_.head_takes = Seconds(1e6);
  const DriveOutcome outcome = Move();
  EXPECT_EQ(outcome.kind, Kind::kFailed);
  EXPECT_EQ(outcome.reason, "neck: still moving after 27.0 s");
  EXPECT_GE(world_.head_stops, 1);
}

/// A look that begins with a motion of the arm.
class DriveWithArm : public Drive {
 protected:
  DriveWithArm() {
    robot_ = testing::MakeFakeRobotWithArm(&world_);
    world_.arm_takes = Seconds(3.0);
    const Eigen::VectorXd rest = Eigen::Vector2d::Zero();
    look_.arm_motion.knots = {{0.0, rest, rest}, {3.0, Eigen::Vector2d(0.4, 0.5), rest}};
  }
};

TEST_F(DriveWithArm, FoldsItBeforeTheBaseDrives) {
  EXPECT_EQ(Move().kind, Kind::kReached);
  EXPECT_EQ(world_.q, Eigen::VectorXd(Eigen::Vector2d(0.4, 0.5)));
  EXPECT_EQ(world_.base_started, world_.arm_started + Seconds(3.0));
  EXPECT_EQ(world_.head_starts, 1);
}

TEST_F(DriveWithArm, LeavesBaseAndHeadAloneWhereTheLookIsTheArms) {
  look_.way = world::LookWay::kArm;
  EXPECT_EQ(Move().kind, Kind::kReached);
  EXPECT_EQ(world_.arm_starts, 1);
  EXPECT_EQ(world_.base_starts, 0);
  EXPECT_EQ(world_.head_starts, 0);
}

TEST_F(DriveWithArm, DoesNotDriveWithAnArmThatCouldNotBeFolded) {
  world_.arm_ends = {MotionPhase::kFailed, "touched something"};
  const DriveOutcome outcome = Move();
  EXPECT_EQ(outcome.kind, Kind::kFailed);
  EXPECT_EQ(outcome.reason, "limb: touched something");
  EXPECT_FALSE(outcome.base_failed);
  EXPECT_EQ(world_.base_starts, 0);
}

TEST_F(DriveWithArm, StopsItOnRequest) {
  EXPECT_EQ(Move([this] { return world_.now >= Time(Seconds(1.0)); }).kind, Kind::kStopped);
  EXPECT_GE(world_.arm_stops, 1);
  EXPECT_EQ(world_.base_starts, 0);
}

}  // namespace
}  // namespace secondlook::apps
