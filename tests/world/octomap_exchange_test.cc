#include "lib/world/octomap_exchange.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::world {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

Vector3d RandomPoint(Rng* rng) {
  return {rng->Uniform(-0.6, 0.6), rng->Uniform(-0.6, 0.6), rng->Uniform(-0.6, 0.6)};
}

BrickGrid RandomGrid() {
  Rng rng(4);
  BrickGrid grid(0.02, {Vector3d::Constant(-0.5), Vector3d::Constant(0.5)});
  grid.Fill({Vector3d(-0.4, -0.3, -0.2), Vector3d(0.1, 0.3, 0.5)}, LogOdds(0.3));
  for (int i = 0; i < 200; ++i) grid.SetPoints({RandomPoint(&rng)}, LogOdds(rng.Uniform(0.2, 0.9)));
  return grid;
}

TEST(OctoMapExchange, AnOctreeHasTheGridsVoxelsAndGivesThemBack) {
  const BrickGrid grid = RandomGrid();
  const octomap::OcTree tree = ToOctree(grid);
  const BrickGrid back = FromOctree(tree);
  Rng rng(5);
  for (int i = 0; i < 5000; ++i) {
    const Vector3d p = RandomPoint(&rng);
    const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
    ASSERT_EQ(node != nullptr, grid.ProbabilityAt(p).has_value());
    const double probability = node == nullptr ? 0.5 : node->getOccupancy();
    EXPECT_NEAR(probability, grid.ProbabilityAt(p).value_or(0.5), 1e-6);
    EXPECT_EQ(back.ProbabilityAt(p), grid.ProbabilityAt(p));
  }
}

TEST(OctoMapExchange, ForCollisionsOnlyWhatIsOccupiedInTheBoxCounts) {
  BrickGrid grid(0.02, {Vector3d::Constant(-0.5), Vector3d::Constant(0.5)});
  grid.Fill(grid.box_W(), -1.0F);
  grid.SetPoints({{0.01, 0.01, 0.01}, {0.01, 0.01, 0.41}}, 2.0F);
  grid.SetStanding({grid.KeyOf({0.05, 0.05, 0.05})}, true);
  const octomap::OcTree tree = OccupiedOctree(grid, {Vector3d(-1, -1, 0.0), Vector3d(1, 1, 0.1)});
  EXPECT_EQ(tree.getNumLeafNodes(), 2U);
  EXPECT_NE(tree.search(0.05, 0.05, 0.05), nullptr);
  EXPECT_EQ(tree.search(0.01, 0.01, 0.41), nullptr);
}

TEST(OctoMapExchange, AFileGivesBackTheMap) {
  const TemporaryFolder folder;
  const BrickGrid grid = RandomGrid();
  for (const char* name : {"map.ot", "map.bt"}) {
    SaveMap(grid, folder / name);
    const BrickGrid read = LoadMap(folder / name, 0.02);
    Rng rng(7);
    for (int i = 0; i < 5000; ++i) {
      const Vector3d p = RandomPoint(&rng);
      EXPECT_EQ(read.At(p), grid.At(p)) << name;
    }
  }
}

TEST(OctoMapExchange, RefusesFilesThatAreNoMap) {
  const TemporaryFolder folder;
  SaveMap(RandomGrid(), folder / "map.bt");
  SaveMap(RandomGrid(), folder / "map.ot");
  EXPECT_THROWS(LoadMap(folder / "map.bt", 0.01), ConfigError, "set voxel_m to match");
  EXPECT_THROWS(LoadMap(folder / "map.ot", 0.01), ConfigError, "set voxel_m to match");
  EXPECT_THROWS(LoadMap(folder / "missing.ot", 0.02), ConfigError, "missing.ot");
  WriteFile(folder / "hello.bt", "hello");
  EXPECT_THROWS(LoadMap(folder / "hello.bt", 0.02), ConfigError, "no octree");
  EXPECT_THROWS(SaveMap(RandomGrid(), folder / "map.txt"), ConfigError,
                "ends in .bt or .ot, not in '.txt'");
  const BrickGrid empty(0.02, {Vector3d::Zero(), Vector3d::Ones()});
  SaveMap(empty, folder / "empty.bt");
  EXPECT_THROWS(LoadMap(folder / "empty.bt", 0.02), ConfigError, "it holds nothing");
}

TEST(OctoMapExchange, RefusesFilesThatAreCutOffOrGarbled) {
  const TemporaryFolder folder;
  for (const std::string name : {"map.bt", "map.ot"}) {
    SaveMap(RandomGrid(), folder / name);
    const std::string whole = ReadFile(folder / name);
    const std::size_t data = whole.find("\ndata\n") + 6;
    for (const double share : {0.0, 0.3, 0.999}) {
      WriteFile(
          folder / ("cut_" + name),
          whole.substr(
              0, data + static_cast<std::size_t>(share * static_cast<double>(whole.size() - data)) +
                     1));
      EXPECT_THROWS(LoadMap(folder / ("cut_" + name), 0.02), ConfigError, "is damaged");
    }
    // Nothing but nodes with eight children each: a tree without end.
    WriteFile(folder / ("deep_" + name), whole.substr(0, data) + std::string(10000, '\xFF'));
    EXPECT_THROWS(LoadMap(folder / ("deep_" + name), 0.02), ConfigError, "is damaged");
    WriteFile(folder / ("more_" + name), whole + "more");
    EXPECT_THROWS(LoadMap(folder / ("more_" + name), 0.02), ConfigError, "is damaged");
  }
}

}  // namespace
}  // namespace secondlook::world
