// Missions of a robot with an arm.

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/experiments/judge.h"
#include "sim/faulty_robot.h"
#include "tests/mission/simulated_mission.h"
#include "tests/support/program.h"
#include "tests/support/small_world.h"

namespace secondlook::apps {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramResult;

class ArmMission : public ::testing::Test {
 protected:
  ArmMission() { world_.LookByArm(); }

  SimulatedMission Run(const std::string& threads) const {
    return SimulatedMission({"threads=" + threads}, {}, world_.config().string());
  }

  testing::SmallWorld world_;
};

/// Runs a mission in which `lost` is off from its first second on; how and why it has ended.
std::pair<Progress, std::string> EndWithout(sim::FaultyPart lost, const std::string& config_file) {
  const RunConfig config = LoadRunConfig(config_file, {});
  const ThreadLimit threads(config.threads);
  const auto database = world::ObjectDatabase::Load(config.models);
  ReadyRobot ready = MakeRobot(config.robot, config.seed);
  const sim::Fault off{lost, sim::FaultType::kOff, Time(Seconds(1)), Time::max()};
  ready.robot = sim::WithFaults(std::move(ready.robot), {off}, 1);
  Publisher publisher;
  Mission mission(
      config.mission, config.task, database, ready.calibration, config.seed, [] { return false; },
      &publisher, &ready.robot);
  mission.KnowArm(*ready.hand);
  Progress progress = Progress::kMore;
  for (int i = 0; i < 30 && progress == Progress::kMore; ++i) progress = mission.Step();
  return {progress, mission.record().end};
}

TEST_F(ArmMission, GoesOnWithTheLooksOfTheHeadWhenTheHandsCameraIsLost) {
  const auto [progress, end] = EndWithout(sim::FaultyPart::kHandCamera, world_.config().string());
  EXPECT_NE(progress, Progress::kMore);
  EXPECT_NE(progress, Progress::kFailed);
  EXPECT_THAT(end, HasSubstr("; without looks by arm 'arm', as camera 'hand': the device is lost"));
}

TEST_F(ArmMission, GoesOnWithTheLooksOfTheHeadWhenTheArmIsLost) {
  const auto [progress, end] = EndWithout(sim::FaultyPart::kArm, world_.config().string());
  EXPECT_NE(progress, Progress::kMore);
  EXPECT_NE(progress, Progress::kFailed);
  EXPECT_THAT(end, HasSubstr("; without looks by arm 'arm', as arm 'arm': the device is lost"));
}

TEST_F(ArmMission, SettlesByALookThatTheArmTakes) {
  const SimulatedMission run = Run("2");
  EXPECT_EQ(run.progress(), Progress::kSettled) << run.mission().record().end;
  EXPECT_TRUE(run.world().collisions().empty());
  EXPECT_EQ(run.mission().record().metres, 0.0);
  for (const Verdict& v : Judge(run.mission(), run.world())) {
    EXPECT_EQ(v.kind, Verdict::Kind::kRight) << v.truth;
  }
  int by_arm = 0;
  for (const TakenLook& taken : run.mission().record().looks) {
    if (taken.look.way != world::LookWay::kArm) continue;
    ++by_arm;
    EXPECT_EQ(taken.outcome, "reached");
    EXPECT_THAT(taken.look.reason, HasSubstr("s by the arm"));
    EXPECT_TRUE(taken.look.path_W.empty());
    EXPECT_FALSE(taken.look.arm_motion.knots.empty());
  }
  EXPECT_GE(by_arm, 1);
  EXPECT_EQ(run.world().hand_views().size(), static_cast<std::size_t>(by_arm));
  // The hand's view was registered and fused: it is where the hand was, up to its errors.
  const Pose& X_WC = run.mission().belief().views.back().X_WC;
  const Pose& X_WC_true = run.world().hand_views().back().X_WC;
  EXPECT_LT((X_WC.translation() - X_WC_true.translation()).norm(), 0.06);
}

TEST_F(ArmMission, IsTheSameForAnyNumberOfThreads) {
  EXPECT_TRUE(Run("1").Json() == Run("2").Json());
}

TEST_F(ArmMission, LeavesAnArmAloneWhoseCameraMeasuresNoDepth) {
  const ProgramResult result =
      testing::RunProgram({"run", "--config", world_.config().string(), "--lcm-url", "none",
                           "--set", "robot.arm.camera_has_depth=false"});
  EXPECT_THAT(result.err, HasSubstr("camera 'hand' measures no depth, so that its views cannot add "
                                    "to the map: arm 'arm' stays where it is"));
  EXPECT_THAT(result.err, Not(HasSubstr("by the arm;")));
}

}  // namespace
}  // namespace secondlook::apps
