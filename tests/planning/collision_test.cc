#include "lib/planning/collision.h"

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

/// How deep the upright cylinder reaches into the nearest cube, negative when it is free [m].
double Depth(const std::vector<Vector3d>& voxels_W, double edge, const Pose2& X_WB, double radius,
             double low, double high) {
  double deepest = -1.0;
  for (const Vector3d& center_W : voxels_W) {
    const double half = 0.5 * edge;
    const Vector2d away = (Vector2d(X_WB.x, X_WB.y) - center_W.head<2>()).cwiseAbs();
    const double sideways = radius - (away.array() - half).max(0.0).matrix().norm();
    const double upright = std::min(high - (center_W.z() - half), center_W.z() + half - low);
    deepest = std::max(deepest, std::min(sideways, upright));
  }
  return deepest;
}

TEST(CollisionChecker, SaysWhatBruteForceOverTheVoxelsSays) {
  Rng rng(9);
  const CostMapConfig config;
  const double radius = SafeRadius(MakeBase(), config);
  int touching = 0;
  int free = 0;
  for (int trial = 0; trial < 5; ++trial) {
    VoxelSpace space;
    space.ClearBox(Eigen::AlignedBox3d(Vector3d(-0.5, -0.5, 0.2), Vector3d(0.5, 0.5, 0.4)));
    std::vector<Vector3d> points;
    for (int i = 0; i < 40; ++i) {
      points.emplace_back(rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-0.1, 1.6));
    }
    space.MarkOccupied(points);
    const world::BrickGrid& grid = space.surroundings();
    std::vector<Vector3d> voxels_W;
    for (const Vector3d& p : points) voxels_W.push_back(grid.CenterOf(grid.KeyOf(p)));
    const CollisionChecker checker(space, {}, MakeBase(), config);
    for (int i = 0; i < 100; ++i) {
      const Pose2 X_WB{rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-3, 3)};
      const double depth =
          Depth(voxels_W, grid.voxel(), X_WB, radius, config.min_height_m, MakeBase().height);
      if (std::abs(depth) < 0.002) continue;  // FCL's tolerance
      EXPECT_EQ(checker.Touches(X_WB).has_value(), depth > 0.0) << X_WB.x << ", " << X_WB.y;
      ++(depth > 0.0 ? touching : free);
    }
  }
  EXPECT_GT(touching, 50);
  EXPECT_GT(free, 50);
}

TEST(CollisionChecker, ATableReachesDownToTheFloor) {
  const VoxelSpace empty;
  // 1.2 m along the diagonal direction, 0.8 m across.
  const CollisionChecker checker(empty, {MakeSupport({1.0, 1.0, 0.75}, {1.2, 0.8}, 0.785398)},
                                 MakeBase());
  const auto at = [](double along, double across) {
    const double c = std::sqrt(0.5);
    return Pose2{1.0 + c * (along - across), 1.0 + c * (along + across), 0.0};
  };
  // The edge is 0.4 m across, grown by 0.03; 0.33 m have to be kept.
  EXPECT_TRUE(checker.Touches(at(0.0, 0.75)).has_value());
  EXPECT_FALSE(checker.Touches(at(0.0, 0.77)).has_value());
  EXPECT_TRUE(checker.Touches(at(0.95, 0.0)).has_value());
  EXPECT_FALSE(checker.Touches(at(0.97, 0.0)).has_value());
  ASSERT_TRUE(checker.Touches(at(0.0, 0.0)).has_value());
  EXPECT_TRUE(checker.Touches(at(0.0, 0.0))->support);
}

TEST(CollisionChecker, RefusesBadInput) {
  const VoxelSpace empty;
  const CollisionChecker checker(empty, {}, MakeBase());
  EXPECT_THROWS(checker.Touches({NAN, 0, 0}), InvalidArgument, "the pose (nan, 0) m");
  EXPECT_THROWS(CollisionChecker(empty, {}, {"base", -0.1, 1.0, 1.0, 1.0}), InvalidArgument,
                "radius -0.1 m");
}

}  // namespace
}  // namespace secondlook::planning
