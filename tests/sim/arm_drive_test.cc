#include "sim/arm_drive.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "lib/common/error.h"
#include "sim/fixtures.h"
#include "sim/ground_truth.h"
#include "tests/sim/rig.h"
#include "tests/support/expect_throws.h"

namespace secondlook::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

SimArmConfig Described() {
  SimArmConfig config;
  config.urdf = "sim/robots/arm.urdf";
  return config;
}

std::shared_ptr<SimulatedRobot> MakeWithArm(const Scene& scene, const NoiseConfig& noise,
                                            std::uint64_t seed) {
  SimConfig config;
  config.noise = noise;
  config.arm = Described();
  return MakeShared(scene, config, seed);
}

/// From rest to rest by one cubic, in `seconds`.
void MoveTo(SimulatedRobot* robot, const Eigen::VectorXd& goal, double seconds) {
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(goal.size());
  robot->robot.arm->Start({{{0.0, robot->robot.arm->State().q, rest}, {seconds, goal, rest}}});
  while (robot->robot.arm->Status().phase == hal::MotionPhase::kMoving) robot->world->Step();
}

/// The error of the hand camera's pose in the base: what is true against what the files say.
Pose CameraError(const SimulatedRobot& robot) {
  const Pose said = CameraInBase(*robot.hand, robot.world->arm()->encoders());
  return said.inverse() * robot.world->arm()->TrueCameraInBase();
}

TEST(ArmDrive, IsWhereItsEncodersSayWithoutNoise) {
  const auto s = MakeWithArm(FreeScene(), NoiseConfig::None(), 1);
  Eigen::VectorXd goal = s->robot.arm->State().q;
  goal[6] += 0.5;
  MoveTo(s.get(), goal, 2.0);
  EXPECT_TRUE(CameraError(*s).isApprox(Pose::Identity(), 1e-9));
}

TEST(ArmDrive, ErrsAnewWithEachMotionAndByTheHandEyeErrorThatStays) {
  // The flange errs by 1 mm and 0.1 degrees, the mounting of the camera by 1 mm and 0.2 degrees.
  NoiseConfig noise;
  double square_flange = 0.0, square_turn = 0.0, square_mounting = 0.0;
  const int robots = 40;
  const int motions = 5;
  for (int seed = 0; seed < robots; ++seed) {
    const auto s = MakeWithArm(FreeScene(), noise, seed);
    const Eigen::VectorXd home = s->robot.arm->State().q;
    std::vector<Eigen::Vector3d> seen;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (int i = 0; i < motions; ++i) {
      Eigen::VectorXd goal = home;
      goal[6] -= 0.2 * (i + 1);
      MoveTo(s.get(), goal, 2.0);
      const Pose error = CameraError(*s);
      seen.push_back(error.translation());
      mean += error.translation() / motions;
      square_turn += std::pow(RotationDistance(Eigen::Matrix3d::Identity(), error.linear()), 2);
    }
    for (const Eigen::Vector3d& p : seen) square_flange += (p - mean).squaredNorm();
    square_mounting += mean.squaredNorm();
  }
  // The camera sits 7 cm from the flange's origin: 0.1 degrees there move it by 0.12 mm, which
  // 1 mm drowns.
  const double flange = std::sqrt(square_flange / (3.0 * robots * (motions - 1)));
  EXPECT_NEAR(flange, 0.001, 0.0001);
  const double mounting = std::sqrt(square_mounting / (3.0 * robots) - 0.001 * 0.001 / motions);
  EXPECT_NEAR(mounting, 0.001, 0.0003);
  const double turn = std::sqrt(square_turn / (3.0 * robots * motions)) / kDegree;
  EXPECT_NEAR(turn, std::hypot(0.1, 0.2), 0.04);
}

TEST(ArmDrive, BrakesWithinItsAccelerationWhenItIsStopped) {
  const auto s = MakeWithArm(FreeScene(), NoiseConfig::None(), 1);
  const Eigen::VectorXd home = s->robot.arm->State().q;
  Eigen::VectorXd goal = home;
  goal[6] -= 1.5;
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(goal.size());
  s->robot.arm->Start({{{0.0, home, rest}, {2.0, goal, rest}}});
  for (int i = 0; i < 100; ++i) s->world->Step();
  const double middle = s->robot.arm->State().q[6];
  s->robot.arm->Stop();
  while (s->robot.arm->Status().phase == hal::MotionPhase::kMoving) s->world->Step();
  // At 1.125 rad/s and 2.618 rad/s^2 it stands after 0.242 rad.
  EXPECT_NEAR(middle - s->robot.arm->State().q[6], 1.125 * 1.125 / (2.0 * 150.0 * kDegree), 0.02);
}

TEST(World, NamesWhatTheArmRunsInto) {
  Scene scene = FreeScene();
  scene.robot = {{0.0, 0.0}, 0.0};
  // A post where the outstretched arm comes by, too far for the base to touch.
  scene.boxes.push_back({.name = "post", .size = {0.1, 0.1, 2.0}, .position = {0.6, -0.1, 0.0}});
  const auto s = MakeWithArm(scene, NoiseConfig::None(), 1);
  Eigen::VectorXd goal = s->robot.arm->State().q;
  goal[0] = 0.0;
  goal[1] = 80.0 * kDegree;
  goal[3] = 0.0;
  goal[5] = 0.0;
  EXPECT_TRUE(s->world->collisions().empty());
  MoveTo(s.get(), goal, 6.0);
  ASSERT_EQ(s->world->collisions().size(), 1U);
  EXPECT_EQ(s->world->collisions()[0].name, "post");
  EXPECT_TRUE(s->world->collisions()[0].arm);
}

TEST(SimCamera, ShowsTheRobotItsOwnArmWhereItIsInView) {
  Scene scene = FreeScene();
  scene.robot = {{0.0, 0.0}, 0.0};
  const auto s = MakeWithArm(scene, NoiseConfig::None(), 1);
  GroundTruth truth(*s->world);
  const auto own_pixels = [&] {
    const auto frame = s->robot.head_camera->Grab(Seconds(1));
    const Render clean = truth.CleanFrame(frame->sequence, s->robot.head_camera->info().model);
    return cv::countNonZero(clean.id == kOwnBodyId);
  };
  s->robot.head->Start({0.0, 0.5});
  WaitForHead(s.get());
  EXPECT_EQ(own_pixels(), 0);  // folded behind the camera
  Eigen::VectorXd goal = s->robot.arm->State().q;
  goal[0] = 0.0;
  goal[1] = 60.0 * kDegree;
  goal[3] = 30.0 * kDegree;
  MoveTo(s.get(), goal, 6.0);
  EXPECT_GT(own_pixels(), 5000);
}

TEST(SimCamera, IsCarriedByTheHand) {
  Scene scene = FreeScene();
  scene.robot = {{0.0, 0.0}, 0.0};
  scene.table.position = {0.9, 0.0};
  const auto s = MakeWithArm(scene, NoiseConfig::None(), 1);
  Eigen::VectorXd goal = Eigen::VectorXd::Zero(7);
  goal[1] = 5.0 * kDegree;
  goal[3] = -35.0 * kDegree;
  goal[5] = 120.0 * kDegree;  // 160 degrees in all: down and 20 degrees ahead
  MoveTo(s.get(), goal, 6.0);
  const auto frame = s->robot.hand_camera->Grab(Seconds(1));
  ASSERT_TRUE(frame);
  // Shoulder at 0.70 m, then 0.42 m at 5 degrees from upright, 0.40 m at 40, and 0.126 + 0.032 m at
  // 160; the lens sits 0.06 m to the side. The top of the table is at 0.75 m.
  const double height = 0.70 + 0.42 * std::cos(5.0 * kDegree) + 0.40 * std::cos(40.0 * kDegree) +
                        0.158 * std::cos(160.0 * kDegree) - 0.06 * std::sin(160.0 * kDegree);
  EXPECT_NEAR(frame->depth.at<float>(240, 320), (height - 0.75) / std::cos(20.0 * kDegree), 0.005);
}

TEST(SimCamera, OfTheHandHasColourAloneIfThatIsWanted) {
  SimConfig config;
  config.arm = Described();
  config.arm->camera_has_depth = false;
  const auto s = MakeShared(FreeScene(), config, 1);
  EXPECT_FALSE(s->robot.hand_camera->info().has_depth);
  const auto frame = s->robot.hand_camera->Grab(Seconds(1));
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->depth.empty());
  EXPECT_EQ(frame->color.cols, 640);
}

TEST(LoadArm, NamesWhatIsWrong) {
  EXPECT_THROWS(LoadArm({}), ConfigError, "'urdf' is missing");
  SimArmConfig config = Described();
  config.tip = "gripper";
  EXPECT_THROWS(LoadArm(config), ConfigError, "has no link 'gripper'");
  config = Described();
  config.home_deg = {0.0, 0.0};
  EXPECT_THROWS(LoadArm(config), ConfigError,
                "home_deg has 2 angles, but 'sim/robots/arm.urdf' has 7 joints up to 'flange'");
  config = Described();
  config.home_deg[1] = 130.0;
  EXPECT_THROWS(LoadArm(config), ConfigError,
                "home_deg[1] = 130, but joint 'joint_2' reaches from -120.0 to 120.0 deg");
  config = Described();
  config.acceleration_deg = 0.0;
  EXPECT_THROWS(LoadArm(config), ConfigError, "acceleration_deg = 0 must be positive");
  config = Described();
  config.camera_position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROWS(LoadArm(config), ConfigError, "must be finite");
}

}  // namespace
}  // namespace secondlook::sim
