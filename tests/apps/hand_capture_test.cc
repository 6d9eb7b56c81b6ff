#include <algorithm>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "apps/arm_looks.h"
#include "apps/capture.h"
#include "lib/common/error.h"
#include "lib/kinematics/box_of_moved.h"
#include "sim/faulty_robot.h"
#include "sim/sim_robot.h"
#include "tests/support/expect_throws.h"

namespace secondlook::apps {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// A robot with an arm, outstretched over nothing.
class HandCapture : public ::testing::Test {
 protected:
  HandCapture() {
    sim::SimConfig config;
    config.arm.emplace().urdf = "sim/robots/arm.urdf";
    sim::Scene scene;
    scene.table.position = {3.0, 2.0};
    scene.floor.size = {10.0, 8.0};
    scene.robot = {{0.5, -0.3}, 40.0};
    simulated_ = sim::MakeSimulatedRobot(scene, config, 4);
  }

  void Stretch() {
    hal::Robot& robot = simulated_.robot;
    const Eigen::VectorXd q = robot.arm->State().q;
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(q.size());
    Eigen::VectorXd ahead = rest;
    ahead[0] = -30.0 * kDegree;
    ahead[1] = 60.0 * kDegree;
    ahead[3] = -40.0 * kDegree;
    robot.arm->Start({{{0.0, q, rest}, {8.0, ahead, rest}}});
    while (robot.arm->Status().phase == hal::MotionPhase::kMoving) simulated_.world->Step();
  }

  sim::SimulatedRobot simulated_;
};

TEST_F(HandCapture, PutsTheCameraWhereTheHandTrulyIsUpToTheErrorsOfBaseArmAndCalibration) {
  Stretch();
  Capturer capturer(&simulated_.robot, simulated_.calibration);
  capturer.KnowArm(*simulated_.hand);
  const Capture capture = capturer.Take(Seconds(1), world::LookWay::kArm).value();
  EXPECT_EQ(capture.camera_name, "hand");
  const Pose X_true = simulated_.world->hand_views().back().X_WC;
  const Pose X_error = X_true.inverse() * capture.X_WC;
  // Localisation: sigma 15 mm in x and y and 0.7 degrees, at a lever of less than 1 m.
  EXPECT_LT(X_error.translation().norm(), 0.06);
  EXPECT_LT(Eigen::AngleAxisd(X_error.linear()).angle(), 2.5 * kDegree);
  const Pose2 X_WB = simulated_.robot.base->State().X_WB;
  EXPECT_NEAR((capture.X_WC.translation() + capture.p_CB_W - ToPose(X_WB).translation()).norm(),
              0.0, 1e-9);
}

TEST_F(HandCapture, GoesOnWithTheHeadOnceTheArmIsLost) {
  const sim::Fault off{sim::FaultyPart::kArm, sim::FaultType::kOff, Time(Seconds(5)), Time::max()};
  simulated_.robot = sim::WithFaults(std::move(simulated_.robot), {off}, 1);
  Capturer capturer(&simulated_.robot, simulated_.calibration);
  capturer.KnowArm(*simulated_.hand);
  EXPECT_FALSE(capturer.LoseArm()) << "nobody knows yet where it is";
  EXPECT_TRUE(capturer.Take(Seconds(1)));
  const Eigen::VectorXd folded = capturer.ArmNow();
  simulated_.robot.clock->SleepUntil(Time(Seconds(6)));
  EXPECT_THROWS(capturer.Take(Seconds(1)), DeviceError, "arm 'arm': the device is lost");
  EXPECT_TRUE(capturer.LoseArm());
  EXPECT_TRUE(capturer.Take(Seconds(1)));
  EXPECT_EQ(capturer.ArmNow(), folded);
}

TEST_F(HandCapture, LooksOnlyFromWithinTheWorkspaceOfTheArm) {
  hal::Robot& robot = simulated_.robot;
  const kinematics::Chain& chain = simulated_.hand->arm;
  const Eigen::VectorXd folded = robot.arm->State().q;
  const Stance stance{robot.base->State().X_WB, {}, folded, {}};
  ArmLooksConfig config;
  config.obstacles.avoid_unknown = false;
  ArmLooks looks(
      config, {robot.base->info(), robot.arm->info(), robot.hand_camera->info(), *simulated_.hand},
      folded, 1);
  const Eigen::Vector3d p_WT = ToPose(stance.X_WB) * Eigen::Vector3d(0.75, -0.1, 0.7);
  const auto longest_reach = [&] {
    double reach = 0.0;
    const auto collision = looks.CollisionAt(stance, world::VoxelSpace(), {});
    for (const world::Look& look : looks.Views(p_WT, 0, stance, collision)) {
      if (!look.feasible) continue;
      for (double t = 0.0; t <= look.arm_motion.seconds(); t += 0.02) {
        const Eigen::VectorXd q = hal::Sample(look.arm_motion, t).q;
        reach = std::max(reach, kinematics::BoxOfMoved(chain, q).max().x());
      }
    }
    return reach;
  };
  EXPECT_GT(longest_reach(), 0.45);
  const auto below = [](double x, double z) {
    return Eigen::AlignedBox3d(Eigen::Vector3d::Constant(-10.0), Eigen::Vector3d(x, 10.0, z));
  };
  looks.KeepWithin(below(0.4, 10.0));
  const double kept = longest_reach();
  EXPECT_GT(kept, 0.0) << "some look is left";
  EXPECT_LE(kept, 0.4);
  EXPECT_THROWS(looks.KeepWithin(below(10.0, 0.5)), ConfigError,
                "arm 'arm': where it stands at the beginning it reaches from (");
}

TEST_F(HandCapture, OfAnArmThatDoesNotBeginWithinItsBaseIsRefused) {
  hal::Robot& robot = simulated_.robot;
  const HandDevices devices{robot.base->info(), robot.arm->info(), robot.hand_camera->info(),
                            *simulated_.hand};
  EXPECT_NO_THROW(ArmLooks({}, devices, robot.arm->State().q, 1));
  Stretch();
  EXPECT_THROWS(ArmLooks({}, devices, robot.arm->State().q, 1), ConfigError,
                "arm 'arm': where it stands at the beginning it reaches ");
}

}  // namespace
}  // namespace secondlook::apps
