#include "lib/planning/motion/obstacles.h"

#include <limits>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// True when some box of the kind holds the point.
bool Blocked(const std::vector<Obstacle>& obstacles, ObstacleKind kind, const Vector3d& p_W) {
  for (const Obstacle& obstacle : obstacles) {
    if (obstacle.kind != kind) continue;
    if (geometry::Distance(obstacle.solid.shape, obstacle.solid.X_AS.inverse() * p_W) == 0.0) {
      return true;
    }
  }
  return false;
}

TEST(ObstaclesAround, AreWhatTheMapSaysVoxelByVoxel) {
  // A fine workspace within coarser surroundings, both with free, occupied and unknown places.
  Rng rng(5);
  world::VoxelSpace space({}, AlignedBox3d(Vector3d(-0.2, -0.2, 0.3), Vector3d(0.3, 0.2, 0.6)));
  space.ClearBox({Vector3d(-0.5, -0.4, 0.1), Vector3d(0.4, 0.5, 0.7)});
  std::vector<Vector3d> occupied;
  for (int i = 0; i < 300; ++i) {
    occupied.emplace_back(rng.Uniform(-.6, .6), rng.Uniform(-.6, .6), rng.Uniform(0, .8));
  }
  space.MarkOccupied(occupied);
  const auto obstacles = ObstaclesAround({0, 0, 0.4}, 0.8, space, {}, {});
  int seen[3] = {};
  for (int i = 0; i < 3000; ++i) {
    Vector3d p_W(rng.Uniform(-.7, .7), rng.Uniform(-.7, .7), rng.Uniform(0.01, .9));
    if (i % 5 == 0) p_W = occupied[i / 10] + 0.01 * p_W;  // in or beside an occupied voxel
    if ((p_W - Vector3d(0, 0, 0.4)).norm() > 0.8) continue;
    const world::Occupancy state = space.At(p_W);
    ++seen[static_cast<int>(state)];
    EXPECT_EQ(Blocked(obstacles, ObstacleKind::kOccupied, p_W),
              state == world::Occupancy::kOccupied);
    EXPECT_EQ(Blocked(obstacles, ObstacleKind::kUnknown, p_W), state == world::Occupancy::kUnknown);
  }
  for (const int count : seen) EXPECT_GT(count, 15);
}

TEST(ObstaclesAround, AreAFewLargeBoxesWhereWholeBricksAreAlike) {
  // Unknown throughout: 1 m in bricks of 0.16 m, a box each.
  EXPECT_LT(ObstaclesAround({0, 0, 0.5}, 0.5, world::VoxelSpace(), {}, {}).size(), 400U);
}

TEST(ObstaclesAround, LeaveUnknownSpaceOutWhereTheRobotStandsAndIfItIsAllowed) {
  const world::VoxelSpace space;
  const std::vector<geometry::PlacedShape> body{{geometry::Sphere{0.1}, Pose::Identity()}};
  const auto obstacles = ObstaclesAround({0, 0, 0}, 0.6, space, {}, body);
  EXPECT_FALSE(Blocked(obstacles, ObstacleKind::kUnknown, {0.1, 0.0, 0.1}));
  EXPECT_TRUE(Blocked(obstacles, ObstacleKind::kUnknown, {0.2, 0.0, 0.2}));
  ObstacleConfig config;
  config.avoid_unknown = false;
  EXPECT_EQ(ObstaclesAround({0, 0, 0}, 0.6, space, {}, {}, config).size(), 1U);  // the floor
}

TEST(ObstaclesAround, HoldWhatLiesBelowASupportSurfaceAndTheFloor) {
  world::SupportPlane plane_W;
  plane_W.offset = 0.7;
  plane_W.corners_A = {Vector3d(0, 0, .7), Vector3d(1, 0, .7), Vector3d(1, 1, .7),
                       Vector3d(0, 1, .7)};
  const auto obstacles = ObstaclesAround({0, 0, 0.5}, 1.0, world::VoxelSpace(), {plane_W}, {});
  EXPECT_TRUE(Blocked(obstacles, ObstacleKind::kSupport, {0.5, 0.5, 0.1}));
  EXPECT_TRUE(Blocked(obstacles, ObstacleKind::kSupport, {-0.015, 0.5, 0.69}));
  EXPECT_FALSE(Blocked(obstacles, ObstacleKind::kSupport, {0.5, 0.5, 0.71}));
  EXPECT_TRUE(Blocked(obstacles, ObstacleKind::kFloor, {0.5, 0.5, -0.01}));
}

TEST(WallsAround, LeaveTheBoxFreeAndNothingBesideIt) {
  Pose X_WA = ToPose(Pose2{0.5, -0.2, 0.7});
  X_WA.translation().z() = 0.3;
  const AlignedBox3d box_A(Vector3d(-0.3, -0.4, 0.1), Vector3d(0.9, 0.6, 1.2));
  const auto walls = WallsAround(box_A, X_WA);
  Rng rng(2);
  int inside = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vector3d p_A(rng.Uniform(-2.0, 2.0), rng.Uniform(-2.0, 2.0), rng.Uniform(-1.5, 2.5));
    inside += box_A.contains(p_A) ? 1 : 0;
    EXPECT_EQ(Blocked(walls, ObstacleKind::kWorkspaceEdge, X_WA * p_A), !box_A.contains(p_A));
  }
  EXPECT_GT(inside, 10);
}

TEST(ObstaclesAround, RefuseWhatIsNotValid) {
  const world::VoxelSpace space;
  EXPECT_THROWS(
      ObstaclesAround({std::numeric_limits<double>::quiet_NaN(), 0, 0}, 1.0, space, {}, {}),
      InvalidArgument, "obstacles: a reach of 1 m around (nan, 0, 0) m");
  EXPECT_THROWS(ObstaclesAround({0, 0, 0}, 0.0, space, {}, {}), InvalidArgument, "reach of 0 m");
  ObstacleConfig config;
  config.own_space_m = -1.0;
  EXPECT_THROWS(ObstaclesAround({0, 0, 0}, 1.0, space, {}, {}, config), ConfigError,
                "own_space_m = -1 must lie in 0..1");
}

}  // namespace
}  // namespace secondlook::planning
