#include "sim/faulty_robot.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/expect_throws.h"
#include "tests/support/fake_robot.h"

namespace secondlook::sim {
namespace {

using hal::MotionPhase;

/// A fake robot with one fault, from 10 s to 20 s.
struct Faulty {
  Faulty(FaultyPart part, FaultType type)
      : robot(WithFaults(testing::MakeFakeRobotWithArm(&world),
                         {{part, type, Time(Seconds(10)), Time(Seconds(20))}}, 1)) {
    world.base_takes = Seconds(5);
    world.head_takes = Seconds(5);
  }

  void At(double seconds) { world.now = Time(Seconds(seconds)); }
  void AddFrame() {
    world.frames.push_back({world.now, ++sequence, cv::Mat(48, 64, CV_8UC3, cv::Scalar(7)),
                            cv::Mat(48, 64, CV_32F, cv::Scalar(2.0))});
  }
  hal::RgbdFrame Grab() {
    AddFrame();
    return *robot.head_camera->Grab(Seconds(1.0));
  }
  MotionPhase DriveFor(double seconds) {
    robot.base->Start({{{1.0, 0.0, 0.0}}});
    world.Advance(Seconds(seconds));
    return robot.base->Status().phase;
  }

  testing::FakeWorld world;
  hal::Robot robot;
  std::uint64_t sequence{};
};

TEST(FaultyRobot, HasMoreThanTwentyKindsOfFaultEachNamedOnce) {
  std::set<std::string> names;
  for (const Fault& fault : AllFaults(true)) names.insert(ToString(fault));
  EXPECT_EQ(names.size(), AllFaults(true).size());
  EXPECT_GT(AllFaults(false).size(), 20U);
  EXPECT_TRUE(names.contains("localisation delayed"));
}

TEST(FaultyRobot, IsWellBeforeAndAfterItsFault) {
  Faulty faulty(FaultyPart::kHeadCamera, FaultType::kOff);
  EXPECT_EQ(faulty.Grab().depth.at<float>(5, 5), 2.0F);
  faulty.At(10.0);
  EXPECT_THROWS(faulty.robot.head_camera->Grab({}), DeviceError,
                "camera 'eye': the device is lost (simulated)");
  faulty.At(20.0);
  EXPECT_NO_THROW(faulty.Grab());
}

TEST(FaultyRobot, HasACameraThatMeasuresWrongly) {
  Faulty faulty(FaultyPart::kHeadCamera, FaultType::kWrong);
  faulty.At(10.0);
  EXPECT_FLOAT_EQ(faulty.Grab().depth.at<float>(5, 5), 2.2F);
}

TEST(FaultyRobot, HasACameraWhoseClockJumps) {
  Faulty faulty(FaultyPart::kHeadCamera, FaultType::kClockJump);
  faulty.At(10.0);
  EXPECT_EQ(faulty.Grab().time, Time(Seconds(15)));
}

TEST(FaultyRobot, HasABlindCamera) {
  Faulty faulty(FaultyPart::kHeadCamera, FaultType::kBlind);
  faulty.At(10.0);
  EXPECT_TRUE(std::isnan(faulty.Grab().depth.at<float>(5, 5)));
}

TEST(FaultyRobot, HasABaseThatRefuses) {
  Faulty faulty(FaultyPart::kBase, FaultType::kRefuses);
  faulty.At(10.0);
  EXPECT_EQ(faulty.DriveFor(0.0), MotionPhase::kFailed);
  EXPECT_EQ(faulty.world.base_starts, 0);
}

TEST(FaultyRobot, HasABaseThatAbortsOnItsWay) {
  Faulty faulty(FaultyPart::kBase, FaultType::kAborts);
  faulty.At(10.0);
  EXPECT_EQ(faulty.DriveFor(1.0), MotionPhase::kMoving);
  faulty.world.Advance(Seconds(1.0));
  EXPECT_EQ(faulty.robot.base->Status().phase, MotionPhase::kMoving);  // it brakes
  EXPECT_EQ(faulty.robot.base->Status().phase, MotionPhase::kFailed);
  EXPECT_EQ(faulty.world.base_status.phase, MotionPhase::kStopped);
}

TEST(FaultyRobot, HasABaseThatStopsShortAndSaysThatItHasArrived) {
  Faulty faulty(FaultyPart::kBase, FaultType::kStopsShort);
  faulty.At(10.0);
  EXPECT_EQ(faulty.DriveFor(2.0), MotionPhase::kMoving);  // it brakes
  EXPECT_EQ(faulty.world.base_status.phase, MotionPhase::kStopped);
  EXPECT_EQ(faulty.robot.base->Status().phase, MotionPhase::kReached);
}

TEST(FaultyRobot, SaysThatItHasFailedOnceItStands) {
  Faulty faulty(FaultyPart::kHead, FaultType::kAborts);
  faulty.world.head_takes = Seconds(2.5);
  faulty.At(10.0);
  faulty.robot.head->Start({0.5, 0.0});
  faulty.world.Advance(Seconds(2.0));
  const hal::MotionStatus status = faulty.robot.head->Status();
  EXPECT_EQ(status.phase, MotionPhase::kMoving);  // it brakes
  EXPECT_EQ(faulty.world.head_status.phase, MotionPhase::kStopped);
  EXPECT_EQ(faulty.robot.head->Status().phase, MotionPhase::kFailed);
}

TEST(FaultyRobot, HasASlowHeadThatTakesThreeSecondsLonger) {
  Faulty faulty(FaultyPart::kHead, FaultType::kSlow);
  faulty.At(10.0);
  faulty.robot.head->Start({0.5, 0.0});
  faulty.world.Advance(Seconds(5.0));
  EXPECT_EQ(faulty.robot.head->Status().phase, MotionPhase::kMoving);
  faulty.world.Advance(Seconds(2.9));
  EXPECT_EQ(faulty.robot.head->Status().phase, MotionPhase::kMoving);
  faulty.world.Advance(Seconds(0.1));
  EXPECT_EQ(faulty.robot.head->Status().phase, MotionPhase::kReached);
}

TEST(FaultyRobot, HasAnArmThatFailsWhereAJointComesNearItsLimit) {
  Faulty faulty(FaultyPart::kArm, FaultType::kAtLimit);
  faulty.world.arm_takes = Seconds(5.0);
  faulty.At(10.0);
  hal::JointTrajectory trajectory;
  trajectory.knots.resize(2);
  trajectory.knots[0].q = Eigen::Vector2d(0.0, 0.0);
  trajectory.knots[1].q = Eigen::Vector2d(1.9, 0.0);
  faulty.robot.arm->Start(trajectory);
  faulty.world.q[0] = 1.5;
  EXPECT_EQ(faulty.robot.arm->Status().phase, MotionPhase::kMoving);
  faulty.world.q[0] = 1.7;
  const hal::MotionStatus status = faulty.robot.arm->Status();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_EQ(status.reason, "joint 'lift' has come to its limit (simulated)");
}

TEST(FaultyRobot, HasALocalisationThatSaysWhereItIsOnceInThreeSeconds) {
  Faulty faulty(FaultyPart::kLocalisation, FaultType::kSlow);
  faulty.At(10.0);
  EXPECT_EQ(faulty.robot.base->State().time, Time(Seconds(10)));
  faulty.At(12.9);
  EXPECT_EQ(faulty.robot.base->State().time, Time(Seconds(10)));
  faulty.At(13.0);
  EXPECT_EQ(faulty.robot.base->State().time, Time(Seconds(13)));
}

TEST(FaultyRobot, HasABaseWhoseOdometryIsNoNumber) {
  Faulty faulty(FaultyPart::kBase, FaultType::kGarbage);
  faulty.At(10.0);
  EXPECT_TRUE(std::isnan(faulty.robot.base->State().X_OB.x));
  EXPECT_EQ(faulty.robot.base->State().X_WB.x, 0.0);
}

TEST(FaultyRobot, HasAStuckBaseThatMovesForEverUntilItIsStopped) {
  Faulty faulty(FaultyPart::kBase, FaultType::kStuck);
  faulty.At(10.0);
  EXPECT_EQ(faulty.DriveFor(9.0), MotionPhase::kMoving);
  EXPECT_EQ(faulty.world.base_starts, 0);
  faulty.robot.Stop();
  EXPECT_EQ(faulty.robot.base->Status().phase, MotionPhase::kStopped);
}

TEST(FaultyRobot, NeverSetsOutLateAfterAStop) {
  Faulty faulty(FaultyPart::kBase, FaultType::kDelayed);
  faulty.At(10.0);
  EXPECT_EQ(faulty.DriveFor(1.0), MotionPhase::kMoving);
  faulty.robot.Stop();
  faulty.world.Advance(Seconds(5.0));
  EXPECT_EQ(faulty.robot.base->Status().phase, MotionPhase::kStopped);
  EXPECT_EQ(faulty.world.base_starts, 0);
}

TEST(FaultyRobot, HasALocalisationThatIsStuckWhileTheBaseDrives) {
  Faulty faulty(FaultyPart::kLocalisation, FaultType::kStuck);
  faulty.At(9.0);
  const Time before = faulty.robot.base->State().time;
  faulty.world.X_WB.x = 3.0;
  faulty.At(10.0);
  EXPECT_EQ(faulty.robot.base->State().time, before);
  EXPECT_EQ(faulty.robot.base->State().X_WB.x, 0.0);
  faulty.At(20.0);
  EXPECT_EQ(faulty.robot.base->State().X_WB.x, 3.0);
}

}  // namespace
}  // namespace secondlook::sim
