#include "lib/planning/path.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector2d;
using secondlook::testing::MakeBase;
using secondlook::testing::MakeSupport;
using world::VoxelSpace;

CostMapConfig SmallMap() {
  CostMapConfig config;
  config.reach_m = 1.2;
  config.clearance_m = 0.0;
  config.localisation_sigma_m = 0.0;
  return config;
}

hal::BaseInfo ThinBase() { return {"base", 0.08, 1.0, 0.5, 1.0}; }

/// A map of random discs, partly seen.
CostMap RandomMap(Rng* rng) {
  VoxelSpace space;
  Eigen::AlignedBox3d seen(Eigen::Vector3d(-1.2, -1.2, 0.3), Eigen::Vector3d(0.2, 1.2, 0.34));
  space.ClearBox(seen);
  CostMap map(space, {}, ThinBase(), {0.0, 0.0}, SmallMap());
  for (int i = 0; i < 12; ++i) {
    map.Block({rng->Uniform(-1.2, 1.2), rng->Uniform(-1.2, 1.2)}, rng->Uniform(0.02, 0.2));
  }
  return map;
}

/// Cost to every cell by relaxing all edges until nothing changes (Bellman and Ford).
std::vector<double> BruteForce(const CostMap& map, const CostMap::Cell& start) {
  const int n = map.size();
  std::vector<double> cost(n * n, std::numeric_limits<double>::infinity());
  cost[start.y() * n + start.x()] = 0.0;
  for (bool changed = true; changed;) {
    changed = false;
    for (int i = 0; i < n * n; ++i) {
      const CostMap::Cell a(i % n, i / n);
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const CostMap::Cell b = a + CostMap::Cell(dx, dy);
          if (!map.Contains(b) || !map.Passable(b)) continue;
          if (!map.Passable({a.x(), b.y()}) || !map.Passable({b.x(), a.y()})) continue;
          const double edge = std::hypot(dx, dy) * 0.05 * (map.Cost(a) + map.Cost(b)) / 2.0;
          double& there = cost[b.y() * n + b.x()];
          if (cost[i] + edge < there - 1e-12) {
            there = cost[i] + edge;
            changed = true;
          }
        }
      }
    }
  }
  return cost;
}

TEST(Routes, CostsAreThoseOfBruteForceOnRandomMaps) {
  int reachable = 0;
  int unreachable = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Rng rng(seed);
    const CostMap map = RandomMap(&rng);
    Pose2 start{};
    do {
      start = {rng.Uniform(-1.1, 1.1), rng.Uniform(-1.1, 1.1), 0.0};
    } while (!map.Passable(map.CellOf({start.x, start.y})));
    const Routes routes(map, start, ThinBase());
    const std::vector<double> expected = BruteForce(map, map.CellOf({start.x, start.y}));
    for (int i = 0; i < map.size() * map.size(); ++i) {
      const CostMap::Cell cell(i % map.size(), i / map.size());
      if (std::isinf(expected[i])) {
        EXPECT_TRUE(std::isinf(routes.CostTo(cell)));
        ++unreachable;
      } else {
        EXPECT_NEAR(routes.CostTo(cell), expected[i], 1e-9);
        ++reachable;
      }
    }
  }
  EXPECT_GT(reachable, 1000);
  EXPECT_GT(unreachable, 100);
}

TEST(Routes, WaysStayClearAndAreNoLongerThanOverTheGrid) {
  int found = 0;
  for (std::uint64_t seed = 10; seed < 20; ++seed) {
    Rng rng(seed);
    const CostMap map = RandomMap(&rng);
    Pose2 start{};
    do {
      start = {rng.Uniform(-1.1, 1.1), rng.Uniform(-1.1, 1.1), 0.0};
    } while (!map.Passable(map.CellOf({start.x, start.y})));
    const Routes routes(map, start, ThinBase());
    for (int i = 0; i < 30; ++i) {
      const Pose2 goal{rng.Uniform(-1.1, 1.1), rng.Uniform(-1.1, 1.1), rng.Uniform(-3, 3)};
      const PlannedPath path = routes.To(goal);
      EXPECT_EQ(path.found, path.reason.empty());
      if (!path.found) continue;
      ++found;
      EXPECT_EQ(path.waypoints_W.back(), goal);
      Vector2d at(start.x, start.y);
      double metres = 0.0;
      for (const Pose2& waypoint : path.waypoints_W) {
        const Vector2d next(waypoint.x, waypoint.y);
        metres += (next - at).norm();
        for (int s = 0; s <= 100; ++s) {
          EXPECT_GE(map.Clearance(map.CellOf(at + (next - at) * (s / 100.0))),
                    map.safe_radius() - 0.075);  // the corner of a cell may be cut
        }
        at = next;
      }
      EXPECT_NEAR(path.metres, metres, 1e-9);
      EXPECT_LE(path.metres, routes.CostTo(map.CellOf({goal.x, goal.y})) + 0.1);
      EXPECT_GE(path.metres, std::hypot(goal.x - start.x, goal.y - start.y) - 1e-9);
    }
  }
  EXPECT_GT(found, 50);
}

TEST(Routes, AFreeWayIsOneStraightLine) {
  const CostMap map(VoxelSpace(), {}, MakeBase(), {0.0, 0.0});
  const Routes routes(map, {-1.0, -0.5, 0.0}, MakeBase());
  const PlannedPath path = routes.To({1.0, 0.5, std::numbers::pi / 2});
  ASSERT_TRUE(path.found) << path.reason;
  ASSERT_EQ(path.waypoints_W.size(), 1U);
  EXPECT_NEAR(path.metres, std::sqrt(5.0), 1e-9);
  // Turn to atan(1/2), drive 2.236 m at 0.5 m/s, turn on to 90 degrees: at 1 rad/s.
  EXPECT_NEAR(path.seconds, std::numbers::pi / 2 + std::sqrt(5.0) / 0.5, 1e-9);
}

TEST(Routes, GoAroundATable) {
  const CostMap map(VoxelSpace(), {MakeSupport({0, 0, 0.75}, {1.2, 0.8})}, MakeBase(), {0, 0});
  const Routes routes(map, {-1.2, 0.0, 0.0}, MakeBase());
  const PlannedPath path = routes.To({1.2, 0.0, std::numbers::pi});
  ASSERT_TRUE(path.found) << path.reason;
  // 0.33 m off the long side at y = 0.43 and off its ends at x = +-0.63: at least
  // 2 hypot(0.57, 0.76) + 1.26 m; the grid rounds up.
  EXPECT_GT(path.metres, 3.1);
  EXPECT_LT(path.metres, 3.5);
  EXPECT_LE(path.waypoints_W.size(), 6U);
  EXPECT_EQ(routes.To({1.2, 0.0, 0.0}).waypoints_W.size(), path.waypoints_W.size());
}

TEST(Routes, SayWhyThereIsNoWay) {
  CostMap map(VoxelSpace(), {MakeSupport({0, 0, 0.75}, {1.2, 0.8})}, MakeBase(), {0, 0});
  const Routes routes(map, {-1.2, 0.0, 0.0}, MakeBase());
  EXPECT_THAT(routes.To({0.0, 0.5, 0.0}).reason, ::testing::HasSubstr("the base needs 0.330 m"));
  EXPECT_THAT(routes.To({5.0, 0.0, 0.0}).reason,
              ::testing::HasSubstr("the goal (5.00, 0.00) m lies outside of the map"));
  const Routes outside(map, {-5.0, 0.0, 0.0}, MakeBase());
  EXPECT_THAT(outside.To({1.2, 0.0, 0.0}).reason,
              ::testing::HasSubstr("the start (-5.00, 0.00) m lies outside"));
  for (int i = -60; i <= 60; ++i) map.Block({0.9, 0.05 * i}, 0.0);
  const Routes walled(map, {-1.2, 0.0, 0.0}, MakeBase());
  EXPECT_THAT(walled.To({1.6, 0.0, 0.0}).reason,
              ::testing::HasSubstr("no way from (-1.20, 0.00) to (1.60, 0.00) m"));
}

TEST(Routes, LeaveABlockedStartOnlyAwayFromWhatBlocksIt) {
  CostMap map(VoxelSpace(), {MakeSupport({0, 0, 0.75}, {1.2, 0.8})}, MakeBase(), {0, 0});
  // 0.2 m from the table's edge, where 0.33 m are wanted.
  const Pose2 start{-0.8, 0.0, 0.0};
  EXPECT_FALSE(map.Passable(map.CellOf({start.x, start.y})));
  const PlannedPath path = Routes(map, start, MakeBase()).To({-1.5, 0.0, 0.0});
  ASSERT_TRUE(path.found) << path.reason;
  EXPECT_NEAR(path.metres, 0.7, 0.1);
  EXPECT_TRUE(Routes(map, start, MakeBase()).To({1.5, 0.0, 0.0}).found);
  // Staying is always possible.
  EXPECT_TRUE(Routes(map, start, MakeBase()).To({-0.8, 0.0, 1.0}).found);
  // Hemmed in between the table and a wall there is nothing to be gained anywhere.
  for (int i = -60; i <= 60; ++i) map.Block({-1.0, 0.05 * i}, 0.0);
  EXPECT_THAT(Routes(map, start, MakeBase()).To({-2.0, 0.0, 0.0}).reason,
              ::testing::HasSubstr("no way out of the start (-0.80, 0.00) m"));
}

TEST(Routes, RefuseBadInput) {
  const CostMap map(VoxelSpace(), {}, MakeBase(), {0.0, 0.0});
  EXPECT_THROWS(Routes(map, {NAN, 0, 0}, MakeBase()), InvalidArgument, "start (nan, 0) m");
  EXPECT_THROWS(Routes(map, {0, 0, 0}, {"base", 0.2, 1.0, 0.0, 1.0}), InvalidArgument,
                "speed of 0 m/s");
  EXPECT_THROWS(Routes(map, {0, 0, 0}, MakeBase()).To({0, 0, NAN}), InvalidArgument, "goal (0, 0)");
}

}  // namespace
}  // namespace secondlook::planning
