#include "sim/world.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/sim/rig.h"

namespace secondlook::sim {
namespace {

TEST(World, StepsByTheHundredthOfASecond) {
  const auto s = MakeShared(FreeScene(), NoiseConfig::None(), 1);
  EXPECT_EQ(s->world->Now(), Time{});
  s->world->Step();
  EXPECT_EQ(s->world->Now(), Time(Seconds(0.01)));
}

TEST(World, ThinkingMovesItOnByAllThatIsCharged) {
  Scene scene = FreeScene();
  scene.moving_obstacles.push_back({.waypoints = {{-3, 3}, {3, 3}}, .speed = 0.5});
  const auto s = MakeShared(scene, NoiseConfig::None(), 1);
  for (int i = 0; i < 100; ++i) s->robot.clock->ChargeThinking(Seconds(0.004));
  EXPECT_EQ(s->world->Now(), Time(Seconds(0.4)));
  EXPECT_NEAR(s->world->StateAt(s->world->Now()).obstacles_W[0].x(), -2.8, 0.006);
}

TEST(World, AMovingObstacleGoesToAndFro) {
  Scene scene = FreeScene();
  scene.moving_obstacles.push_back({.waypoints = {{-3, 3}, {-2, 3}, {-2, 2}}, .speed = 1.0});
  const auto s = MakeShared(scene, NoiseConfig::None(), 1);
  const auto at = [&](double seconds) {
    s->robot.clock->SleepUntil(Time(Seconds(seconds)));
    return s->world->StateAt(s->world->Now()).obstacles_W[0];
  };
  EXPECT_LT((at(0.5) - Eigen::Vector2d(-2.5, 3.0)).norm(), 0.03);
  EXPECT_LT((at(1.5) - Eigen::Vector2d(-2.0, 2.5)).norm(), 0.03);
  EXPECT_LT((at(2.5) - Eigen::Vector2d(-2.0, 2.5)).norm(), 0.05);
  EXPECT_LT((at(3.5) - Eigen::Vector2d(-2.5, 3.0)).norm(), 0.05);
  EXPECT_LT((at(4.5) - Eigen::Vector2d(-2.5, 3.0)).norm(), 0.07);
}

TEST(World, AMovingObstacleDoesNotRunIntoTheRobot) {
  Scene scene = FreeScene();
  scene.moving_obstacles.push_back({.waypoints = {{-3, 0}, {3, 0}}, .speed = 1.0});
  const auto s = MakeShared(scene, NoiseConfig::None(), 1);
  s->robot.clock->SleepUntil(Time(Seconds(10)));
  EXPECT_TRUE(s->world->collisions().empty());
  EXPECT_LT(s->world->StateAt(s->world->Now()).obstacles_W[0].x(), -0.28 - 0.25);
}

TEST(World, RecordsACollisionOnceAndNamesWhatWasHit) {
  Scene scene = FreeScene();
  scene.boxes.push_back({.name = "crate", .size = {0.4, 0.4, 0.5}, .position = {0.3, 0.0, 0.0}});
  const auto s = MakeShared(scene, NoiseConfig::None(), 1);  // begins inside the crate
  for (int i = 0; i < 10; ++i) s->world->Step();
  ASSERT_EQ(s->world->collisions().size(), 1U);
  EXPECT_EQ(s->world->collisions()[0].name, "crate");
  EXPECT_EQ(s->world->collisions()[0].base_speed, 0.0);
}

TEST(World, TheHeadPointsBesideWhereItsEncodersSayBySigma) {
  double squares = 0.0;
  int motions = 0;
  for (int seed = 0; seed < 20; ++seed) {
    const auto s = MakeShared(FreeScene(), NoiseConfig{}, seed);
    for (int i = 0; i < 20; ++i) {
      s->robot.head->Start({i % 2 == 0 ? 0.8 : -0.6, 0.3});
      WaitForHead(s.get());
      const hal::PanTiltAngles encoders = s->robot.head->State().angles;
      const kinematics::HeadAngles truth = s->world->StateAt(s->world->Now()).head;
      squares += std::pow(truth.pan - encoders.pan, 2) + std::pow(truth.tilt - encoders.tilt, 2);
      motions += 2;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / motions), 0.1 / 180 * M_PI, 0.1 * 0.1 / 180 * M_PI);
}

TEST(World, TheCameraSitsBesideItsNominalPlaceBySigmaFixedForAMission) {
  double squares = 0.0;
  double angle_squares = 0.0;
  for (int seed = 0; seed < 200; ++seed) {
    NoiseConfig noise = NoiseConfig::None();
    noise.extrinsics_sigma = 0.003;
    noise.extrinsics_sigma_deg = 0.3;
    const auto s = MakeShared(FreeScene(), noise, seed);
    const auto offset = [&] {
      const WorldState& state = s->world->StateAt(s->world->Now());
      const Pose nominal =
          ToPose(state.X_WB) * kinematics::CameraInBase(s->calibration, state.head);
      return Pose(nominal.inverse() * s->world->CameraPose(state));
    };
    const Pose first = offset();
    squares += first.translation().squaredNorm() / 3;
    angle_squares += std::pow(RotationDistance(Eigen::Matrix3d::Identity(), first.linear()), 2) / 3;
    s->robot.head->Start({0.5, 0.5});
    WaitForHead(s.get());
    EXPECT_TRUE(first.isApprox(offset(), 1e-9));
  }
  EXPECT_NEAR(std::sqrt(squares / 200), 0.003, 0.0003);
  EXPECT_NEAR(std::sqrt(angle_squares / 200), 0.3 / 180 * M_PI, 0.1 * 0.3 / 180 * M_PI);
}

}  // namespace
}  // namespace secondlook::sim
