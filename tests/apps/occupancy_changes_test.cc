#include "apps/occupancy_changes.h"

#include <gtest/gtest.h>

namespace secondlook::apps {
namespace {

const Eigen::AlignedBox3d kAll(Eigen::Vector3d::Constant(-2.0), Eigen::Vector3d::Constant(2.0));

TEST(OccupancyChanges, TellsABlockOnceUntilItChangesAgain) {
  world::VoxelSpace space({.voxel_m = 0.1});
  OccupancyChanges changes;
  EXPECT_TRUE(changes.Since(space, kAll).empty()) << "nothing is known yet";

  // Voxel (1, -1, 9): block (0, -1, 1), cell (1, 7, 1), bit 1 + 8 * 7 + 64 * 1 = 121.
  space.MarkOccupied({{0.15, -0.05, 0.95}});
  const auto first = changes.Since(space, kAll);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].index[0], 0);
  EXPECT_EQ(first[0].index[1], -1);
  EXPECT_EQ(first[0].index[2], 1);
  for (int i = 0; i < 64; ++i) {
    EXPECT_EQ(first[0].occupied[i], i == 121 / 8 ? 1 << 121 % 8 : 0) << i;
    EXPECT_EQ(first[0].free[i], 0) << i;
  }
  EXPECT_TRUE(changes.Since(space, kAll).empty()) << "nothing has changed";

  space.RemoveRegion(kAll);
  const auto gone = changes.Since(space, kAll);
  ASSERT_EQ(gone.size(), 1U);
  EXPECT_EQ(gone[0].occupied[121 / 8], 0);
  EXPECT_TRUE(changes.Since(space, kAll).empty());
}

}  // namespace
}  // namespace secondlook::apps
