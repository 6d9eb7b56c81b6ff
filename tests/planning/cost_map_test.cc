#include "lib/planning/cost_map.h"

#include <limits>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using secondlook::testing::MakeBase;
using secondlook::testing::MakeSupport;
using world::VoxelSpace;

TEST(CostMap, OfNothingKnownIsPassableAndDear) {
  const CostMap map(VoxelSpace(), {}, MakeBase(), {1.0, 2.0});
  EXPECT_EQ(map.size(), 120);
  const CostMap::Cell cell = map.CellOf({1.51, 2.01});
  EXPECT_TRUE(map.Contains(cell));
  EXPECT_NEAR((map.CenterOf(cell) - Vector2d(1.525, 2.025)).norm(), 0.0, 1e-9);
  EXPECT_TRUE(map.Passable(cell));
  EXPECT_EQ(map.Cost(cell), 2.0);
  EXPECT_FALSE(map.Contains(map.CellOf({4.1, 2.0})));
  EXPECT_FALSE(map.Contains(map.CellOf({-1e300, 2.0})));
}

TEST(CostMap, OccupiedIsWhatStandsBetweenTheFloorAndTheRobotsHeight) {
  VoxelSpace space;
  space.MarkOccupied({{0.51, 0.01, 0.01},     // the floor
                      {0.01, 0.51, 0.31},     // an obstacle
                      {-0.51, 0.01, 1.51},    // above the robot
                      {0.01, -0.51, 1.25}});  // as high as its head
  const CostMap map(space, {}, MakeBase(), {0.0, 0.0});
  EXPECT_FALSE(map.Occupied(map.CellOf({0.51, 0.01})));
  EXPECT_TRUE(map.Occupied(map.CellOf({0.01, 0.51})));
  EXPECT_FALSE(map.Occupied(map.CellOf({-0.51, 0.01})));
  EXPECT_TRUE(map.Occupied(map.CellOf({0.01, -0.51})));
  EXPECT_EQ(map.Cost(map.CellOf({0.51, 0.01})), 1.0);
  EXPECT_EQ(map.Cost(map.CellOf({0.8, 0.8})), 2.0);
}

TEST(CostMap, NobodyGoesUnderATable) {
  const CostMap map(VoxelSpace(), {MakeSupport({0, 0, 0.75}, {1.2, 0.8})}, MakeBase(), {0, 0});
  EXPECT_TRUE(map.Occupied(map.CellOf({0.0, 0.0})));
  EXPECT_TRUE(map.Occupied(map.CellOf({0.58, 0.38})));
  EXPECT_TRUE(map.Occupied(map.CellOf({0.0, 0.42})));  // grown by 3 cm: the centre at 0.425
  EXPECT_FALSE(map.Occupied(map.CellOf({0.0, 0.48})));
  // 0.25 + 0.05 + 2 * 0.015 m have to be kept.
  EXPECT_NEAR(map.safe_radius(), 0.33, 1e-12);
  EXPECT_FALSE(map.Passable(map.CellOf({0.0, 0.71})));
  EXPECT_TRUE(map.Passable(map.CellOf({0.0, 0.86})));
}

TEST(CostMap, ClearanceIsThatOfBruteForce) {
  Rng rng(2);
  CostMapConfig config;
  config.reach_m = 1.0;
  for (int trial = 0; trial < 5; ++trial) {
    CostMap map(VoxelSpace(), {}, MakeBase(), {0.0, 0.0}, config);
    std::vector<CostMap::Cell> occupied;
    for (int i = 0; i < 1 + 5 * trial; ++i) {
      const Vector2d p(rng.Uniform(-1, 1), rng.Uniform(-1, 1));
      map.Block(p, 0.0);
      occupied.push_back(map.CellOf(p));
    }
    for (int y = 0; y < map.size(); ++y) {
      for (int x = 0; x < map.size(); ++x) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const CostMap::Cell& cell : occupied) {
          nearest = std::min(nearest, (cell - CostMap::Cell(x, y)).cast<double>().norm());
        }
        EXPECT_NEAR(map.Clearance({x, y}), std::max(0.0, nearest - 0.5) * 0.05, 1e-9);
      }
    }
  }
}

TEST(CostMap, BlockMarksADisc) {
  CostMap map(VoxelSpace(), {}, MakeBase(), {0.0, 0.0});
  map.Block({0.5, 0.0}, 0.2);
  EXPECT_TRUE(map.Occupied(map.CellOf({0.5, 0.0})));
  EXPECT_TRUE(map.Occupied(map.CellOf({0.67, 0.0})));
  EXPECT_FALSE(map.Occupied(map.CellOf({0.76, 0.0})));
  EXPECT_FALSE(map.Passable(map.CellOf({0.5, 0.46})));
  EXPECT_TRUE(map.Passable(map.CellOf({0.5, 0.6})));
}

TEST(CostMap, RefusesBadInput) {
  EXPECT_THROWS(CostMap(VoxelSpace(), {}, MakeBase(), {NAN, 0.0}), InvalidArgument, "its centre");
  EXPECT_THROWS(CostMap(VoxelSpace(), {}, {"base", 0.0, 1.0, 1.0, 1.0}, {0, 0}), InvalidArgument,
                "radius 0 m");
  EXPECT_THROWS(CostMap(VoxelSpace(), {MakeSupport({NAN, 0, 0}, {1, 1})}, MakeBase(), {0, 0}),
                InvalidArgument, "corner of a support");
  CostMapConfig config;
  config.unknown_cost = 0.5;
  EXPECT_THROWS(CostMap(VoxelSpace(), {}, MakeBase(), {0, 0}, config), ConfigError,
                "unknown_cost = 0.5");
  CostMap map(VoxelSpace(), {}, MakeBase(), {0, 0});
  EXPECT_THROWS(map.Block({0, 0}, NAN), InvalidArgument, "disc of nan m");
}

}  // namespace
}  // namespace secondlook::planning
