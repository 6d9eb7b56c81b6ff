#include "lib/planning/boundary_search.h"

#include <numbers>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"
#include "tests/support/half_ball.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.05;

/// A ball that was seen from +x alone.
world::PartialMesh HalfBall() {
  return tests::PartOfBall(kRadius, 100, [](const Eigen::Vector3f& p) { return p.x() > -1e-6F; });
}

/// A free map around it.
world::BrickGrid FreeMap() {
  world::BrickGrid grid(0.01, {Vector3d::Constant(-0.8), Vector3d::Constant(0.8)});
  grid.Fill(grid.box_W(), -2.0F);
  return grid;
}

world::LeapField LeapsOf(const world::BrickGrid& grid) {
  world::LeapField leaps;
  leaps.Refresh(grid);
  return leaps;
}

TEST(BoundarySearch, FollowsABallRoundItsEdge) {
  const std::vector<SurfaceTrend> trends = FindTrends(HalfBall(), tests::LevelPlane(-0.1));
  EXPECT_NEAR(static_cast<double>(trends.size()), 2.0 * std::numbers::pi * kRadius / 0.015, 3.0);
  const double turn = 0.02 / kRadius;  // an arc as long as it reaches
  for (const SurfaceTrend& trend : trends) {
    EXPECT_NEAR(trend.p_W.norm(), kRadius, 0.001);
    EXPECT_NEAR(trend.p_W.x(), -kRadius * std::sin(turn), 0.002);
    EXPECT_GT(trend.normal_W.dot(trend.p_W.normalized()), 0.99);
    EXPECT_NEAR(trend.border, 2.0 * std::numbers::pi * kRadius, 0.01);
  }
}

TEST(BoundarySearch, LeadsAcrossAHoleToTheOtherSide) {
  const std::vector<SurfaceTrend> trends = TrendsAcrossHoles(HalfBall(), tests::LevelPlane(-0.1));
  // As many as squares of 15 mm on the disc that closes it.
  const double disc = std::numbers::pi * kRadius * kRadius;
  EXPECT_NEAR(static_cast<double>(trends.size()), disc / (0.015 * 0.015), 1.5);
  Vector3d middle = Vector3d::Zero();
  for (const SurfaceTrend& trend : trends) {
    EXPECT_NEAR(trend.p_W.x(), 0.0, 0.002);
    EXPECT_LT(trend.p_W.norm(), kRadius + 0.001);
    EXPECT_GT(-trend.normal_W.x(), 0.9);
    middle += trend.p_W / static_cast<double>(trends.size());
  }
  EXPECT_LT(middle.norm(), 0.01) << "evenly";
}

TEST(BoundarySearch, LeavesOutWhereAThingStands) {
  const world::PartialMesh dome =
      tests::PartOfBall(kRadius, 100, [](const Eigen::Vector3f& p) { return p.z() > -1e-6F; });
  EXPECT_TRUE(FindTrends(dome, tests::LevelPlane(-0.001)).empty());
  EXPECT_TRUE(TrendsAcrossHoles(dome, tests::LevelPlane(-0.001)).empty());
  EXPECT_TRUE(FindTrends({}, tests::LevelPlane(0.0)).empty());
}

TEST(BoundarySearch, ViewsSeeTheTrendUprightFromTheSensorsBestDistance) {
  const world::SupportPlane plane = tests::LevelPlane(-kRadius);
  const std::vector<SurfaceTrend> trends = FindTrends(HalfBall(), plane);
  const world::BrickGrid grid = FreeMap();
  const std::vector<ScanCandidate> candidates = CandidateScans(trends, grid, LeapsOf(grid), plane);
  ASSERT_GT(candidates.size(), 10U);
  for (const ScanCandidate& candidate : candidates) {
    const SurfaceTrend& trend = trends[candidate.trend];
    const Vector3d way = candidate.X_WC.translation() - trend.p_W;
    EXPECT_NEAR(way.norm(), 0.55, 1e-9);
    EXPECT_GE(way.normalized().dot(trend.normal_W), std::cos(60.1 * std::numbers::pi / 180.0));
    EXPECT_GE(plane.HeightOf(candidate.X_WC.translation()), 0.08);
    EXPECT_EQ(candidate.occlusion, 0.0);
    EXPECT_NEAR((candidate.X_WC.inverse() * trend.p_W).head<2>().norm(), 0.0, 1e-9);
  }
}

TEST(BoundarySearch, ViewsLookPastWhatIsInTheWay) {
  const world::SupportPlane plane = tests::LevelPlane(-0.5);
  const SurfaceTrend trend{Vector3d(0, 0, 0), Vector3d(1, 0, 0), 0.1};
  world::BrickGrid grid = FreeMap();
  grid.Fill({Vector3d(0.2, -0.1, -0.1), Vector3d(0.25, 0.1, 0.1)}, 2.0F);  // before its front
  const std::vector<ScanCandidate> past = CandidateScans({trend}, grid, LeapsOf(grid), plane);
  ASSERT_EQ(past.size(), 1U);
  EXPECT_EQ(past[0].occlusion, 0.0);
  EXPECT_LT(past[0].X_WC.translation().normalized().x(), 0.95);
  grid.Fill({Vector3d(0.2, -0.8, -0.8), Vector3d(0.25, 0.8, 0.8)}, 2.0F);  // a wall
  EXPECT_TRUE(CandidateScans({trend}, grid, LeapsOf(grid), plane).empty());
}

TEST(BoundarySearch, NamesAWrongConfiguration) {
  EXPECT_THROWS(FindTrends({}, tests::LevelPlane(0), {.reach_m = 0.0}), ConfigError,
                "reach_m = 0 must lie in");
}

}  // namespace
}  // namespace secondlook::planning
