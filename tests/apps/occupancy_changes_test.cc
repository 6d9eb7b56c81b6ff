#include "apps/occupancy_changes.h"

#include <gtest/gtest.h>

namespace secondlook::apps {
namespace {

const Eigen::AlignedBox3d kAll(Eigen::Vector3d::Constant(-2.0), Eigen::Vector3d::Constant(2.0));

TEST(OccupancyChanges, TellsABrickOnceUntilItChangesAgain) {
  world::BrickGrid grid(0.1, kAll);
  OccupancyChanges changes;
  EXPECT_TRUE(changes.Since(grid).empty()) << "nothing is known yet";

  // Voxel (1, -1, 9): brick (0, -1, 1), cell (1, 7, 1), bit 1 + 8 * 7 + 64 * 1 = 121.
  grid.SetPoints({{0.15, -0.05, 0.95}}, world::LogOdds(0.9));
  const auto first = changes.Since(grid);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].index[0], 0);
  EXPECT_EQ(first[0].index[1], -1);
  EXPECT_EQ(first[0].index[2], 1);
  for (int i = 0; i < 64; ++i) {
    EXPECT_EQ(first[0].occupied[i], i == 121 / 8 ? 1 << 121 % 8 : 0) << i;
    EXPECT_EQ(first[0].free[i], 0) << i;
  }
  EXPECT_TRUE(changes.Since(grid).empty()) << "nothing has changed";

  grid.SetPoints({{0.15, -0.05, 0.95}}, world::LogOdds(0.1));
  const auto freed = changes.Since(grid);
  ASSERT_EQ(freed.size(), 1U);
  EXPECT_EQ(freed[0].occupied[121 / 8], 0);
  EXPECT_EQ(freed[0].free[121 / 8], 1 << 121 % 8);

  const auto gone = changes.Since(world::BrickGrid(0.1, kAll));
  ASSERT_EQ(gone.size(), 1U) << "a grid made anew knows nothing of it";
  EXPECT_EQ(gone[0].free[121 / 8], 0);
  EXPECT_TRUE(changes.Since(world::BrickGrid(0.1, kAll)).empty());
}

}  // namespace
}  // namespace secondlook::apps
