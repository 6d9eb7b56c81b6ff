#include "lib/planning/hidden_space.h"

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// A table top 1.2 x 0.8 m, 0.75 m above the floor, centred at the origin.
world::SupportPlane Table() {
  world::SupportPlane plane;
  plane.offset = 0.75;
  plane.corners_A = {Vector3d(-0.6, -0.4, 0.75), Vector3d(0.6, -0.4, 0.75),
                     Vector3d(0.6, 0.4, 0.75), Vector3d(-0.6, 0.4, 0.75)};
  return plane;
}

TEST(HiddenRegions, FindsThePartOfTheTableThatWasNotSeen) {
  world::VoxelSpace space;
  space.ClearBox(AlignedBox3d(Vector3d(-0.7, -0.5, 0.7), Vector3d(0.7, 0.5, 1.0)));
  EXPECT_TRUE(HiddenRegions(space, Table(), {}, {}).empty());
  space.RemoveRegion(AlignedBox3d(Vector3d(0.1, 0.0, 0.7), Vector3d(0.4, 0.2, 1.0)));
  const auto regions = HiddenRegions(space, Table(), {}, {});
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_LT((regions[0].center().head<2>() - Eigen::Vector2d(0.25, 0.1)).norm(), 0.03);
  EXPECT_NEAR(regions[0].sizes().x(), 0.3, 0.05);
}

TEST(HiddenRegions, LeavesOutWhatAKnownThingStandsOn) {
  world::VoxelSpace space;
  space.ClearBox(AlignedBox3d(Vector3d(-0.7, -0.5, 0.7), Vector3d(0.7, 0.5, 1.0)));
  const AlignedBox3d thing(Vector3d(0.1, 0.0, 0.75), Vector3d(0.4, 0.2, 0.9));
  space.RemoveRegion(thing);
  EXPECT_TRUE(HiddenRegions(space, Table(), {thing}, {}).empty());
}

TEST(HiddenRegions, GivesARegionOneCellWideAWidth) {
  world::VoxelSpace space;
  space.ClearBox(AlignedBox3d(Vector3d(-0.7, -0.5, 0.7), Vector3d(0.7, 0.5, 1.0)));
  space.RemoveRegion(AlignedBox3d(Vector3d(-0.4, 0.0, 0.7), Vector3d(0.4, 0.015, 1.0)));
  for (const AlignedBox3d& box : HiddenRegions(space, Table(), {}, {})) {
    EXPECT_GT(box.sizes().minCoeff(), 0.02);
  }
}

TEST(HiddenRegions, PutsTheLargestFirstAndLeavesOutTheTiny) {
  world::VoxelSpace space;
  space.ClearBox(AlignedBox3d(Vector3d(-0.7, -0.5, 0.7), Vector3d(0.7, 0.5, 1.0)));
  space.RemoveRegion(AlignedBox3d(Vector3d(-0.4, 0.0, 0.7), Vector3d(-0.35, 0.05, 1.0)));
  space.RemoveRegion(AlignedBox3d(Vector3d(0.3, 0.0, 0.7), Vector3d(0.42, 0.12, 1.0)));
  space.RemoveRegion(AlignedBox3d(Vector3d(-0.1, 0.0, 0.7), Vector3d(0.15, 0.3, 1.0)));
  const auto regions = HiddenRegions(space, Table(), {}, {});
  ASSERT_EQ(regions.size(), 2U);
  EXPECT_LT(regions[0].center().x(), 0.2);
  EXPECT_GT(regions[1].center().x(), 0.2);
}

TEST(HiddenSpaceConfig, NamesTheValueThatMakesNoSense) {
  const auto with = [](double HiddenSpaceConfig::*value, double number) {
    HiddenSpaceConfig config;
    config.*value = number;
    config.Validate();
  };
  EXPECT_THROWS(with(&HiddenSpaceConfig::cell_m, 0.0), ConfigError, "cell_m = 0 must lie in");
  EXPECT_THROWS(with(&HiddenSpaceConfig::height_m, -0.1), ConfigError, "height_m = -0.1 must");
  EXPECT_THROWS(with(&HiddenSpaceConfig::box_height_m, 0.0), ConfigError, "box_height_m = 0 must");
  EXPECT_NO_THROW(HiddenSpaceConfig().Validate());
}

}  // namespace
}  // namespace secondlook::planning
