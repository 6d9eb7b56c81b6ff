#include "lib/world/ray_cast.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/world/octomap_exchange.h"
#include "tests/support/expect_throws.h"

namespace secondlook::world {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr geometry::CameraModel kCamera{64, 48, 60.0, 60.0, 31.5, 23.5};

Vector3d RandomPoint(Rng* rng, double reach) {
  return {rng->Uniform(-reach, reach), rng->Uniform(-reach, reach), rng->Uniform(-reach, reach)};
}

/// Free and unknown boxes with scattered occupied voxels, from -0.5 to 0.5 m.
BrickGrid RandomGrid(Rng* rng) {
  BrickGrid grid(0.02, {Vector3d::Constant(-0.5), Vector3d::Constant(0.5)});
  for (int i = 0; i < 6; ++i) {
    AlignedBox3d box(RandomPoint(rng, 0.5));
    box.extend(RandomPoint(rng, 0.5));
    grid.Fill(box, -1.0F);
  }
  std::vector<Vector3d> points;
  for (int i = 0; i < 400; ++i) points.push_back(RandomPoint(rng, 0.5));
  grid.SetPoints(points, 2.0F);
  return grid;
}

/// The reach of a voxel by looking at all around it.
int BruteReach(const BrickGrid& grid, const VoxelKey& key, Leap leap) {
  const Occupancy state = grid.At(grid.CenterOf(key));
  for (int reach = 1; reach < LeapField::kMaxReach; ++reach) {
    for (int z = -reach; z <= reach; ++z) {
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
          const Vector3d p = grid.CenterOf(key + VoxelKey(x, y, z));
          if (!grid.Contains(p)) continue;
          if (leap == Leap::kToOccupied ? grid.At(p) == Occupancy::kOccupied
                                        : grid.At(p) != state) {
            return reach;
          }
        }
      }
    }
  }
  return LeapField::kMaxReach;
}

TEST(LeapField, ReachesToTheNearestVoxelThatEndsALeapAfterEveryChange) {
  Rng rng(1);
  BrickGrid grid = RandomGrid(&rng);
  LeapField leaps;
  const int all = leaps.Refresh(grid);
  for (int change = 0; change < 8; ++change) {
    for (int i = 0; i < 150; ++i) {
      const VoxelKey key = grid.KeyOf(RandomPoint(&rng, 0.499));
      if (grid.At(grid.CenterOf(key)) == Occupancy::kOccupied) continue;
      const Eigen::Vector3i voxel = key - grid.first_key();
      const auto other = leaps.At<Leap::kToOther>(voxel);
      const auto occupied = leaps.At<Leap::kToOccupied>(voxel);
      EXPECT_EQ(other.state, grid.At(grid.CenterOf(key)));
      // Where whole bricks agree, the reach is at least what voxels could say.
      const int other_reach = other.bits == 0 ? other.reach : LeapField::kMaxReach;
      EXPECT_EQ(other_reach, BruteReach(grid, key, Leap::kToOther));
      const int occupied_reach = occupied.bits == 0 ? occupied.reach : LeapField::kMaxReach;
      EXPECT_EQ(occupied_reach, BruteReach(grid, key, Leap::kToOccupied));
    }
    if (change % 2 == 0) {
      grid.SetPoints({RandomPoint(&rng, 0.5)}, 2.0F);
    } else {
      grid.Forget(AlignedBox3d(RandomPoint(&rng, 0.4) - Vector3d::Constant(0.03),
                               RandomPoint(&rng, 0.4) + Vector3d::Constant(0.05)));
    }
    EXPECT_LE(leaps.Refresh(grid), all);
    EXPECT_EQ(leaps.Refresh(grid), 0) << "nothing has changed since";
  }
}

TEST(LeapField, FollowsAChangedVoxelWithTheBricksAroundItAlone) {
  BrickGrid grid(0.01, {Vector3d::Constant(-1.0), Vector3d::Constant(1.0)});
  grid.Fill(grid.box_W(), -1.0F);
  LeapField leaps;
  leaps.Refresh(grid);
  grid.SetPoints({Vector3d::Constant(0.045)}, 2.0F);
  EXPECT_EQ(leaps.Refresh(grid), 27);
}

TEST(CastRay, EndsAsOctoMapsCastRayDoes) {
  Rng rng(2);
  int rays = 0;
  int alike = 0;
  int hits = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const BrickGrid grid = RandomGrid(&rng);
    LeapField leaps;
    leaps.Refresh(grid);
    const octomap::OcTree tree = ToOctree(grid);
    for (int i = 0; i < 500; ++i) {
      const Vector3d from = RandomPoint(&rng, 0.8);
      const Vector3d way = RandomPoint(&rng, 1.0).normalized();
      for (const RayStop stop : {RayStop::kOccupied, RayStop::kOccupiedOrUnknown}) {
        if (stop == RayStop::kOccupiedOrUnknown && !grid.Contains(from)) continue;
        octomap::point3d end;
        const bool theirs = tree.castRay(
            {static_cast<float>(from.x()), static_cast<float>(from.y()),
             static_cast<float>(from.z())},
            {static_cast<float>(way.x()), static_cast<float>(way.y()), static_cast<float>(way.z())},
            end, stop == RayStop::kOccupied, 3.0);
        const RayEnd ours = CastRay(grid, leaps, from, from + 3.0 * way, stop);
        ++rays;
        hits += theirs ? 1 : 0;
        const bool hit = ours.state == Occupancy::kOccupied;
        const Vector3d there(end.x(), end.y(), end.z());
        alike += hit == theirs && (!hit || grid.KeyOf(there) == ours.voxel) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(hits, 500);
  EXPECT_GE(alike, 0.999 * rays) << "of " << rays;
}

TEST(CastRay, MeasuresTheUnknownUpToItsEnd) {
  BrickGrid grid(0.01, {Vector3d::Constant(-0.4), Vector3d::Constant(0.4)});
  grid.Fill({Vector3d(-0.2, -0.2, -0.2), Vector3d(0.0, 0.2, 0.2)}, -1.0F);
  grid.SetPoints({{0.155, 0.005, 0.005}}, 2.0F);
  LeapField leaps;
  leaps.Refresh(grid);
  // From 0.6 m out: 0.2 m out of the grid, 0.2 m unknown, 0.2 m free, 0.15 m unknown, occupied.
  const RayEnd end = CastRayThroughUnknown(grid, leaps, {-0.6, 0.005, 0.005}, {0.4, 0.005, 0.005});
  EXPECT_EQ(end.state, Occupancy::kOccupied);
  EXPECT_EQ(end.voxel, VoxelKey(15, 0, 0));
  EXPECT_NEAR(end.at, 0.75, 1e-9);
  EXPECT_NEAR(end.unknown, 0.35, 1e-9);
  EXPECT_EQ(
      CastRay(grid, leaps, {-0.15, 0.005, 0.005}, {0.4, 0.005, 0.005}, RayStop::kOccupiedOrUnknown)
          .voxel,
      VoxelKey(0, 0, 0));
}

TEST(CastRay, OfNoLengthAsksTheVoxelAroundIt) {
  BrickGrid grid(0.01, {Vector3d::Constant(-0.4), Vector3d::Constant(0.4)});
  grid.SetPoints({Vector3d::Constant(0.005)}, 2.0F);
  LeapField leaps;
  leaps.Refresh(grid);
  const Vector3d in = Vector3d::Constant(0.004);
  EXPECT_EQ(CastRay(grid, leaps, in, in).state, Occupancy::kOccupied);
  const Vector3d beside = Vector3d::Constant(0.014);
  EXPECT_EQ(CastRay(grid, leaps, beside, beside).state, Occupancy::kFree);
}

TEST(CastFan, SaysOfEveryPixelWhatItsRaySays) {
  Rng rng(3);
  int hits = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const BrickGrid grid = RandomGrid(&rng);
    LeapField leaps;
    leaps.Refresh(grid);
    Pose X_WC = Pose::Identity();
    X_WC.linear() = RotationFromVector(RandomPoint(&rng, 2.0));
    X_WC.translation() = -rng.Uniform(0.0, 1.0) * X_WC.linear().col(2);
    RayFan fan{kCamera, X_WC, {7, 2}, {51, 43}, {}};
    for (int i = 0; i < 51 * 43; ++i) fan.depth.push_back(i % 5 == 0 ? 0.0 : rng.Uniform(0.1, 2));
    const std::vector<RayEnd> fast = CastFan(grid, leaps, fan);
    const std::vector<RayEnd> through = CastFanThroughUnknown(grid, leaps, fan);
    for (int i = 0; i < 51 * 43; ++i) {
      if (fan.depth[i] == 0.0) continue;
      const Vector3d p_WB = X_WC * (fan.depth[i] * kCamera.Ray(7 + i % 51, 2 + i / 51));
      const RayEnd ray = CastRayThroughUnknown(grid, leaps, X_WC.translation(), p_WB);
      hits += ray.state == Occupancy::kOccupied ? 1 : 0;
      EXPECT_EQ(fast[i].state, ray.state);
      EXPECT_EQ(through[i].state, ray.state);
      EXPECT_EQ(fast[i].voxel, ray.voxel);
      EXPECT_EQ(through[i].voxel, ray.voxel);
      EXPECT_NEAR(fast[i].at, ray.at * fan.depth[i], 1e-9);
      EXPECT_NEAR(through[i].at, ray.at * fan.depth[i], 1e-9);
      EXPECT_NEAR(through[i].unknown, ray.unknown * fan.depth[i], 1e-9);
    }
  }
  EXPECT_GT(hits, 500);
}

TEST(CastFan, RefusesDepthsThatDoNotFitItsSize) {
  const BrickGrid grid(0.02, {Vector3d::Constant(-0.5), Vector3d::Constant(0.5)});
  LeapField leaps;
  leaps.Refresh(grid);
  EXPECT_THROWS(CastFan(grid, leaps, {kCamera, Pose::Identity(), {0, 0}, {4, 3}, {1.0}}),
                InvalidArgument, "1 depths for 4 x 3 pixels");
}

}  // namespace
}  // namespace secondlook::world
