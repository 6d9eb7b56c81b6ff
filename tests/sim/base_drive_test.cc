#include "sim/base_drive.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sim/rig.h"

namespace secondlook::sim {
namespace {

constexpr NoiseConfig kDefault;

double Distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// The free room, the robot at the origin with heading 0.
Scene Room() {
  Scene scene = FreeScene();
  scene.robot.yaw_deg = 0.0;
  return scene;
}

TEST(BaseDrive, TakesTheTimeThatItsSpeedAndAccelerationAllow) {
  const auto s = MakeShared(Room(), NoiseConfig::None(), 1);
  s->robot.base->Start({{{2.0, 0.0, 0.0}}});
  EXPECT_EQ(WaitForBase(s.get()).phase, hal::MotionPhase::kReached);
  // 2 m at 0.5 m/s with 0.5 m/s^2: 1 s to speed up, 1 s to brake (0.25 m each), 3 s between.
  EXPECT_NEAR(ToSeconds(s->world->Now()), 5.0, 0.25);
  EXPECT_NEAR(s->world->base().truth().x, 2.0, 0.002);
}

TEST(BaseDrive, EndsWhereLocalisationSaysTheGoalIs) {
  const auto s = MakeShared(Room(), kDefault, 5);
  const Pose2 goal{1.5, 0.5, 1.0};
  s->robot.base->Start({{goal}});
  EXPECT_EQ(WaitForBase(s.get()).phase, hal::MotionPhase::kReached);
  const Pose2 estimate = s->robot.base->State().X_WB;
  EXPECT_LT(Distance(estimate, goal), 0.02);
  EXPECT_NEAR(estimate.yaw, goal.yaw, 0.005);
  EXPECT_GT(Distance(s->world->base().truth(), goal), 1e-4);
}

TEST(BaseDrive, LocalisationErrsBySigmaAnewAtEachStop) {
  double squares = 0.0;
  double yaw_squares = 0.0;
  double products = 0.0;
  int stops = 0;
  for (int seed = 0; seed < 20; ++seed) {
    const auto s = MakeShared(Room(), kDefault, seed);
    double last = 0.0;
    for (int i = 0; i < 10; ++i) {
      s->robot.base->Start({{{i % 2 == 0 ? 1.0 : 0.0, 0.0, 0.5 * i}}});
      ASSERT_EQ(WaitForBase(s.get()).phase, hal::MotionPhase::kReached);
      const Pose2 truth = s->world->base().truth();
      const Pose2 estimate = s->robot.base->State().X_WB;
      const double x = estimate.x - truth.x;
      squares += (x * x + std::pow(estimate.y - truth.y, 2)) / 2;
      yaw_squares += std::pow(WrapAngle(estimate.yaw - truth.yaw), 2);
      products += x * last;
      last = x;
      ++stops;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / stops), 0.015, 0.0015);
  EXPECT_NEAR(std::sqrt(yaw_squares / stops), 0.7 / 180 * M_PI, 0.1 * 0.7 / 180 * M_PI);
  EXPECT_LT(std::abs(products / stops), 0.2 * squares / stops);  // one says nothing of the next
}

TEST(BaseDrive, ReportsTheCovarianceOfItsLocalisation) {
  const auto s = MakeShared(Room(), kDefault, 1);
  const Eigen::Matrix3d covariance = s->robot.base->State().covariance_WB;
  EXPECT_NEAR(covariance(0, 0), 0.015 * 0.015, 1e-12);
  EXPECT_NEAR(covariance(2, 2), std::pow(0.7 / 180 * M_PI, 2), 1e-12);
}

TEST(BaseDrive, OdometryDriftsByOnePercent) {
  double squares = 0.0;
  for (int seed = 0; seed < 100; ++seed) {
    const auto s = MakeShared(Room(), kDefault, seed);
    s->robot.base->Start({{{2.0, 0.0, 0.0}}});
    WaitForBase(s.get());
    const Pose2 X_OB = s->robot.base->State().X_OB;
    const double driven = s->world->base().metres();
    squares += std::pow(std::hypot(X_OB.x, X_OB.y) / driven - 1.0, 2);
  }
  EXPECT_NEAR(std::sqrt(squares / 100), 0.01, 0.002);
}

TEST(BaseDrive, StopsBeforeWhatStandsInTheWayAndSaysWhere) {
  Scene scene = Room();
  scene.boxes.push_back({.name = "crate", .size = {0.4, 0.4, 0.5}, .position = {1.7, 0.0, 0.0}});
  const auto s = MakeShared(scene, NoiseConfig::None(), 1);
  s->robot.base->Start({{{3.0, 0.0, 0.0}}});
  const hal::MotionStatus status = WaitForBase(s.get());
  EXPECT_EQ(status.phase, hal::MotionPhase::kFailed);
  // The crate begins at x = 1.5; the base, 0.28 m in radius, would touch it at 1.22.
  EXPECT_THAT(status.reason, ::testing::HasSubstr("base 'base': blocked after 0.9"));
  EXPECT_THAT(status.reason, ::testing::HasSubstr("m by something at (1.50, 0.00) in W"));
  EXPECT_LT(s->world->base().truth().x, 1.22);
  EXPECT_GT(s->world->base().truth().x, 0.85);
  EXPECT_TRUE(s->world->collisions().empty());
}

TEST(BaseDrive, DrivesAwayFromWhatItStandsClose) {
  Scene scene = Room();
  scene.boxes.push_back({.size = {0.4, 0.4, 0.5}, .position = {0.485, 0.0, 0.0}});  // 5 mm away
  const auto s = MakeShared(scene, NoiseConfig::None(), 1);
  s->robot.base->Start({{{-1.0, 0.0, 0.0}}});
  EXPECT_EQ(WaitForBase(s.get()).phase, hal::MotionPhase::kReached);
}

TEST(BaseDrive, AGoalCloseToAWallIsReached) {
  Scene scene = Room();
  scene.boxes.push_back({.size = {0.4, 0.4, 0.5}, .position = {1.7, 0.0, 0.0}});
  const auto s = MakeShared(scene, NoiseConfig::None(), 1);
  s->robot.base->Start({{{1.19, 0.0, 0.0}}});  // 3 cm between
  EXPECT_EQ(WaitForBase(s.get()).phase, hal::MotionPhase::kReached);
}

TEST(BaseDrive, WaitsForAMovingObstacleToPass) {
  Scene scene = Room();
  // It crosses the way at x = 1.2 when the base is about to pass.
  scene.moving_obstacles.push_back(
      {.radius = 0.25, .waypoints = {{1.2, 1.2}, {1.2, -3.0}}, .speed = 0.5});
  const auto s = MakeShared(scene, NoiseConfig::None(), 1);
  s->robot.base->Start({{{2.5, 0.0, 0.0}}});
  EXPECT_EQ(WaitForBase(s.get()).phase, hal::MotionPhase::kReached);
  EXPECT_GT(ToSeconds(s->world->Now()), 6.5);  // 6 s without
  EXPECT_TRUE(s->world->collisions().empty());
}

TEST(BaseDrive, NeverCollidesOnRandomWaysThroughARoomWithBoxes) {
  Rng rng(4);
  for (int trial = 0; trial < 10; ++trial) {
    Scene scene = Room();
    for (int i = 0; i < 12; ++i) {
      const double angle = rng.Uniform(0.0, 6.28);
      const double radius = rng.Uniform(1.0, 3.5);
      scene.boxes.push_back({.size = {0.3, 0.5, 0.6},
                             .position = {radius * std::cos(angle), radius * std::sin(angle), 0.0},
                             .yaw_deg = rng.Uniform(0.0, 180.0)});
    }
    scene.moving_obstacles.push_back({.waypoints = {{2.0, 2.0}, {-2.0, -2.0}}});
    const auto s = MakeShared(scene, kDefault, trial);
    for (int i = 0; i < 15; ++i) {
      s->robot.base->Start({{{rng.Uniform(-5, 5), rng.Uniform(-4, 4), rng.Uniform(-3, 3)}}});
      const hal::MotionStatus status = WaitForBase(s.get());
      EXPECT_TRUE(status.phase == hal::MotionPhase::kReached ||
                  status.phase == hal::MotionPhase::kFailed);
    }
    for (const Collision& collision : s->world->collisions()) {
      ADD_FAILURE() << collision.name << " at " << ToSeconds(collision.time);
    }
  }
}

}  // namespace
}  // namespace secondlook::sim
