#include "lib/planning/common_ground.h"

#include <gtest/gtest.h>

#include "tests/support/analytic_scene.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector3d;
using secondlook::testing::LookingAt;

const hal::CameraInfo kCamera{"camera", {640, 480, 577.0, 577.0, 319.5, 239.5}, true, 0.5, 4.0};

/// A wall of 0.2 m x 0.2 m at x = 0 that faces +x, a point each 5 mm, and the table under it.
std::vector<perception::SurfacePoint> Wall() {
  std::vector<perception::SurfacePoint> points;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) {
      points.push_back({{0.0, -0.1 + 0.005 * i, 0.8 + 0.005 * j}, Vector3d::UnitX(), 0.002});
      points.push_back({{-0.1 + 0.005 * i, -0.1 + 0.005 * j, 0.8}, Vector3d::UnitZ(), 0.002});
    }
  }
  return points;
}

Pose From(const Vector3d& p_WC) { return LookingAt(p_WC, {0.0, 0.0, 0.9}); }

TEST(CommonGround, IsTheUprightSurfaceThatBothViewsFace) {
  perception::RegisterConfig config;
  config.min_pairs = 700;
  const CommonGround ground(Wall(), config);
  // 1600 points of 5 mm are 625 of 8 mm.
  EXPECT_NEAR(ground.Pairs(From({1.2, 0.0, 1.2}), kCamera), 625.0, 1.0);
  EXPECT_NEAR(ground.Pairs(From({0.6, 1.0, 1.2}), kCamera), 625.0, 1.0);
  EXPECT_EQ(ground.Pairs(From({-1.2, 0.0, 1.2}), kCamera), 0.0) << "from behind";
  EXPECT_EQ(ground.Pairs(From({0.05, 1.2, 1.2}), kCamera), 0.0) << "grazing";
  EXPECT_EQ(ground.Pairs(From({0.4, 0.0, 0.9}), kCamera), 0.0) << "too near for depth";
}

TEST(CommonGround, IsNotCountedBeyondWhatRegistrationWants) {
  perception::RegisterConfig config;
  config.min_pairs = 100;
  EXPECT_NEAR(CommonGround(Wall(), config).Pairs(From({1.2, 0.0, 1.2}), kCamera), 100.0, 1.0);
}

TEST(CommonGround, GivesTheChanceThatAViewCanBeRegistered) {
  perception::RegisterConfig config;
  const Pose front = From({1.2, 0.0, 1.2});
  EXPECT_EQ(CommonGround(Wall(), config).Chance(front, kCamera), 1.0);
  EXPECT_EQ(CommonGround(Wall(), config).Chance(From({-1.2, 0.0, 1.2}), kCamera), 0.0);
  config.min_pairs = 1250;
  EXPECT_NEAR(CommonGround(Wall(), config).Chance(front, kCamera), 0.5, 0.001);
}

}  // namespace
}  // namespace secondlook::planning
