#include "lib/world/voxel_space.h"

#include <limits>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::world {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr geometry::CameraModel kCamera{64, 48, 60.0, 60.0, 31.5, 23.5};

/// A depth image of a wall across the view, `z` [m] away.
cv::Mat Wall(float z) { return {kCamera.height, kCamera.width, CV_32FC1, cv::Scalar(z)}; }

Vector3d RandomPoint(Rng* rng, double reach) {
  return {rng->Uniform(-reach, reach), rng->Uniform(-reach, reach), rng->Uniform(-reach, reach)};
}

TEST(VoxelSpace, KnowsNothingAtFirst) {
  const VoxelSpace space;
  EXPECT_EQ(space.At({0, 0, 0}), Occupancy::kUnknown);
  EXPECT_EQ(space.At({1e9, 0, 0}), Occupancy::kUnknown);
  EXPECT_EQ(space.At(Vector3d::Constant(NAN)), Occupancy::kUnknown);
  const Passage passage = space.Cast({0, 0, 0}, {0, 0.3, 0.4});
  EXPECT_FALSE(passage.blocked);
  EXPECT_NEAR(passage.unknown, 0.5, 1e-6);
  EXPECT_FALSE(space.ProbabilityAt({0, 0, 0}));
  EXPECT_EQ(space.LikelyFreeShare({{0, 0, 0}}), 0.0);
  EXPECT_EQ(space.LikelyFreeShare({}), 0.0);
}

TEST(VoxelSpace, AWallIsOccupiedFreeBeforeItAndUnknownBehind) {
  VoxelSpace space;
  // Looking along +z of W from 5 cm behind its origin: the wall lies in the voxel of z = 1.01 m.
  Pose X_WC = Pose::Identity();
  X_WC.translation().z() = -0.05;
  space.Insert(Wall(1.06F), kCamera, X_WC, 1);
  EXPECT_EQ(space.At({0.01, 0.01, 1.01}), Occupancy::kOccupied);
  EXPECT_EQ(space.At({0.01, 0.01, 0.97}), Occupancy::kFree);
  EXPECT_EQ(space.At({0.01, 0.01, 0.5}), Occupancy::kFree);
  EXPECT_EQ(space.At({0.01, 0.01, 1.05}), Occupancy::kUnknown);
  EXPECT_EQ(space.At({0.9, 0.01, 0.5}), Occupancy::kUnknown);  // outside of the field of view

  const Passage through = space.Cast({0.01, 0.01, 0.2}, {0.01, 0.01, 2.0});
  EXPECT_TRUE(through.blocked);
  EXPECT_NEAR(through.p_WE.z(), 1.0, 1e-6);
  EXPECT_NEAR(through.unknown, 0.0, 1e-9);
  const Passage before = space.Cast({0.01, 0.01, 0.2}, {0.01, 0.01, 0.9});
  EXPECT_FALSE(before.blocked);
  // From behind, the line first crosses what nobody has seen.
  const Passage behind = space.Cast({0.01, 0.01, 2.0}, {0.01, 0.01, 0.2});
  EXPECT_TRUE(behind.blocked);
  EXPECT_NEAR(behind.p_WE.z(), 1.02, 1e-6);
  EXPECT_NEAR(behind.unknown, 0.98, 1e-4);
}

TEST(VoxelSpace, APixelWithoutReturnSaysNothing) {
  VoxelSpace space;
  cv::Mat depth = Wall(std::numeric_limits<float>::quiet_NaN());
  depth.at<float>(0, 0) = 0.0F;
  depth.at<float>(0, 1) = std::numeric_limits<float>::infinity();
  space.Insert(depth, kCamera, Pose::Identity(), 1);
  EXPECT_EQ(space.At({0.0, 0.0, 0.5}), Occupancy::kUnknown);
  for (int i = 0; i < space.surroundings().directory_size(); ++i) {
    EXPECT_EQ(space.surroundings().Find(i), nullptr) << "nothing was entered";
  }
}

TEST(VoxelSpace, WhatLiesBeyondTheRangeIsNotEnteredButTheWayThereIsFree) {
  VoxelSpace space(VoxelSpaceConfig{.max_range_m = 1.0});
  space.Insert(Wall(2.0F), kCamera, Pose::Identity(), 1);
  EXPECT_EQ(space.At({0.01, 0.01, 0.9}), Occupancy::kFree);
  EXPECT_EQ(space.At({0.01, 0.01, 1.2}), Occupancy::kUnknown);
  EXPECT_EQ(space.At({0.01, 0.01, 2.01}), Occupancy::kUnknown);
}

TEST(VoxelSpace, EachVoxelIsUpdatedOnceAnInsertHoweverManyRaysThereAre) {
  VoxelSpace space;
  space.Insert(Wall(1.01F), kCamera, Pose::Identity(), 1);
  EXPECT_NEAR(space.ProbabilityAt({0.01, 0.01, 1.01}).value(), 0.7, 1e-6);
  EXPECT_NEAR(space.ProbabilityAt({0.01, 0.01, 0.5}).value(), 0.4, 1e-6);
}

TEST(VoxelSpace, AVoxelSeenThroughThreeTimesIsLikelyFree) {
  VoxelSpace space;
  const std::vector<Vector3d> points = {{0.01, 0.01, 0.5}, {0.01, 0.01, 1.01}, {0.01, 0.01, 1.5}};
  for (int view = 1; view <= 3; ++view) {
    space.Insert(Wall(1.01F), kCamera, Pose::Identity(), 1);
    // p after n misses: 0.4^n / (0.4^n + 0.6^n) = 0.4, 0.308, 0.229.
    EXPECT_NEAR(space.LikelyFreeShare(points), view == 3 ? 1.0 / 3.0 : 0.0, 1e-12);
  }
}

TEST(VoxelSpace, CastFindsTheFirstOfRandomVoxelsAsSmallStepsDo) {
  Rng rng(6);
  VoxelSpace space;
  std::vector<Vector3d> blocks;
  for (int i = 0; i < 300; ++i) blocks.push_back(RandomPoint(&rng, 0.5));
  space.ClearBox(AlignedBox3d(Vector3d(-0.5, -0.5, -0.5), Vector3d(0.5, 0.5, 0.1)));
  space.MarkOccupied(blocks);
  int blocked = 0;
  for (int i = 0; i < 500; ++i) {
    const Vector3d a = RandomPoint(&rng, 0.7);
    const Vector3d b = RandomPoint(&rng, 0.7);
    constexpr int kSteps = 20000;
    double unknown = 0.0;
    int hit = -1;
    for (int s = 0; s < kSteps && hit < 0; ++s) {
      const Occupancy state = space.At(a + (b - a) * ((s + 0.5) / kSteps));
      if (state == Occupancy::kOccupied) hit = s;
      if (state == Occupancy::kUnknown) unknown += (b - a).norm() / kSteps;
    }
    const Passage passage = space.Cast(a, b);
    if (passage.blocked != (hit >= 0)) {
      // Only a corner cut by less than a step may differ.
      EXPECT_TRUE(passage.blocked) << i;
      continue;
    }
    EXPECT_NEAR(passage.unknown, unknown, 0.001) << i;
    if (!passage.blocked) continue;
    ++blocked;
    EXPECT_NEAR((passage.p_WE - (a + (b - a) * (hit + 0.5) / kSteps)).norm(), 0.0, 2e-4) << i;
  }
  EXPECT_GT(blocked, 50);
}

TEST(VoxelSpace, RegionsCanBeMarkedClearedAndForgotten) {
  VoxelSpace space;
  space.MarkOccupied({{0.01, 0.01, 0.01}, {0.05, 0.01, 0.01}});
  EXPECT_EQ(space.At({0.01, 0.01, 0.01}), Occupancy::kOccupied);
  space.ClearBox(AlignedBox3d(Vector3d(0.0, 0.0, 0.0), Vector3d(0.02, 0.02, 0.02)));
  EXPECT_EQ(space.At({0.01, 0.01, 0.01}), Occupancy::kFree);
  EXPECT_EQ(space.At({0.05, 0.01, 0.01}), Occupancy::kOccupied);
  space.RemoveRegion(AlignedBox3d(Vector3d(0.0, 0.0, 0.0), Vector3d(0.06, 0.02, 0.02)));
  EXPECT_EQ(space.At({0.01, 0.01, 0.01}), Occupancy::kUnknown);
  EXPECT_EQ(space.At({0.05, 0.01, 0.01}), Occupancy::kUnknown);
}

TEST(VoxelSpace, ForgettingABoxForgetsItsVoxelsAndNoOthers) {
  Rng rng(8);
  for (int trial = 0; trial < 20; ++trial) {
    VoxelSpace space;
    space.Insert(Wall(1.01F), kCamera, Pose::Identity(), 1);
    const VoxelSpace before = space;
    AlignedBox3d box;
    box.extend(RandomPoint(&rng, 0.5) + Vector3d(0, 0, 0.6));
    box.extend(RandomPoint(&rng, 0.5) + Vector3d(0, 0, 0.6));
    space.RemoveRegion(box);
    for (int i = 0; i < 2000; ++i) {
      const Vector3d p = RandomPoint(&rng, 0.7) + Vector3d(0, 0, 0.6);
      const Vector3d center = ((p / 0.02).array().floor() + 0.5) * 0.02;
      EXPECT_EQ(space.At(p), box.contains(center) ? Occupancy::kUnknown : before.At(p));
    }
  }
  VoxelSpace space;
  space.Insert(Wall(1.01F), kCamera, Pose::Identity(), 1);
  space.RemoveRegion(AlignedBox3d(Vector3d(-9, -9, -9), Vector3d(9, 9, 9)));
  EXPECT_EQ(space.At({0.01, 0.01, 1.01}), Occupancy::kUnknown);
  space.Insert(Wall(1.01F), kCamera, Pose::Identity(), 1);
  EXPECT_EQ(space.At({0.01, 0.01, 1.01}), Occupancy::kOccupied);
}

TEST(VoxelSpace, ACopyIsIndependent) {
  VoxelSpace space(VoxelSpaceConfig{.hit_probability = 0.9});
  VoxelSpace copy = space;
  copy.Insert(Wall(1.01F), kCamera, Pose::Identity(), 1);
  EXPECT_EQ(space.At({0.01, 0.01, 1.01}), Occupancy::kUnknown);
  EXPECT_NEAR(copy.ProbabilityAt({0.01, 0.01, 1.01}).value(), 0.9, 1e-6);  // the config, too
}

/// A workspace of 0.8 m around (0, 0, 1), seen from the origin, a wall in its middle.
VoxelSpace WithWorkspace() {
  return VoxelSpace({}, AlignedBox3d(Vector3d(-0.4, -0.4, 0.6), Vector3d(0.4, 0.4, 1.4)));
}

TEST(VoxelSpace, TheWorkspaceAnswersWithItsFinerVoxels) {
  VoxelSpace space = WithWorkspace();
  space.Insert(Wall(1.005F), kCamera, Pose::Identity(), 1);
  // The wall lies in the fine voxel from 1.00 to 1.01 and in the coarse one from 1.00 to 1.02.
  EXPECT_EQ(space.At({0.005, 0.005, 1.005}), Occupancy::kOccupied);
  EXPECT_EQ(space.At({0.005, 0.005, 1.015}), Occupancy::kUnknown);
  EXPECT_EQ(space.surroundings().At({0.005, 0.005, 1.015}), Occupancy::kOccupied);
  EXPECT_EQ(space.At({0.005, 0.005, 0.5}), Occupancy::kFree);  // before it, in the surroundings
}

TEST(VoxelSpace, ALineIsFollowedThroughSurroundingsAndWorkspace) {
  VoxelSpace space = WithWorkspace();
  space.ClearBox(AlignedBox3d(Vector3d(-0.1, -0.1, 0.0), Vector3d(0.1, 0.1, 2.0)));
  const Vector3d a(0.005, 0.005, 0.1);
  const Vector3d b(0.005, 0.005, 1.9);
  EXPECT_FALSE(space.Cast(a, b).blocked);
  EXPECT_NEAR(space.Cast(a, b).unknown, 0.0, 1e-9);
  space.RemoveRegion(AlignedBox3d(Vector3d(-1, -1, 1.3), Vector3d(1, 1, 1.5)));
  EXPECT_NEAR(space.Cast(a, b).unknown, 0.2, 1e-9);  // half of it in the one, half in the other
  for (const double z : {1.705, 1.105, 0.305}) {     // ever nearer: behind, inside, before
    space.MarkOccupied({{0.005, 0.005, z}});
    const Passage passage = space.Cast(a, b);
    EXPECT_TRUE(passage.blocked);
    EXPECT_NEAR(passage.p_WE.z(), z - 0.005, 1e-9);
  }
}

TEST(VoxelSpace, AFanSaysOfEachPixelWhatItsLineSays) {
  Rng rng(12);
  VoxelSpace space = WithWorkspace();
  space.ClearBox(AlignedBox3d(Vector3d(-0.6, -0.3, 0.2), Vector3d(0.6, 0.3, 1.2)));
  std::vector<Vector3d> blocks;
  for (int i = 0; i < 900; ++i) blocks.push_back(RandomPoint(&rng, 0.4) + Vector3d(0, 0, 1));
  space.MarkOccupied(blocks);
  Pose X_WC = Pose::Identity();
  X_WC.translation() << 0.0123, -0.0234, 0.0345;  // where rays do not run along edges
  RayFan fan{kCamera, X_WC, {3, 5}, {50, 40}, {}};
  for (int i = 0; i < 50 * 40; ++i) fan.depth.push_back(i % 7 == 0 ? 0.0 : rng.Uniform(0.3, 1.9));
  const std::vector<Passage> passages = space.Cast(fan);
  ASSERT_EQ(passages.size(), fan.depth.size());
  int blocked = 0;
  for (int i = 0; i < 50 * 40; ++i) {
    const Passage& passage = passages[i];
    if (fan.depth[i] == 0.0) {
      EXPECT_FALSE(passage.blocked);
      EXPECT_EQ(passage.unknown, 0.0);
      continue;
    }
    const Passage line =
        space.Cast(X_WC.translation(), X_WC * (fan.depth[i] * kCamera.Ray(3 + i % 50, 5 + i / 50)));
    EXPECT_EQ(passage.blocked, line.blocked) << i;
    EXPECT_NEAR(passage.unknown, line.unknown, 1e-9) << i;
    EXPECT_NEAR((passage.p_WE - line.p_WE).norm(), 0.0, 1e-9) << i;
    blocked += line.blocked ? 1 : 0;
  }
  EXPECT_GT(blocked, 100);
}

TEST(VoxelSpace, APlacedModelIsSolidAndLeavesWhatWasMeasured) {
  VoxelSpace space = WithWorkspace();
  space.ClearBox(AlignedBox3d(Vector3d(-0.4, -0.4, 0.6), Vector3d(0.4, 0.4, 1.0)));
  const geometry::Mesh box = geometry::MakeBox({0.2, 0.2, 0.2}, {1, 1, 1});
  Pose X_WM = Pose::Identity();
  X_WM.translation() << 0.005, 0.005, 1.005;
  const Vector3d in_the_free(0.005, 0.005, 0.955);
  const Vector3d in_the_unknown(0.005, 0.005, 1.055);
  space.Place(3, box, X_WM);
  EXPECT_EQ(space.At(in_the_free), Occupancy::kOccupied);
  EXPECT_EQ(space.At(in_the_unknown), Occupancy::kOccupied);
  EXPECT_EQ(space.surroundings().At(in_the_free), Occupancy::kOccupied);
  // What it is judged by is what was measured, not that it stands there.
  EXPECT_EQ(space.LikelyFreeShare({in_the_free, in_the_unknown}), 0.5);

  space.Place(4, box, X_WM);  // a second at the same place holds it when the first leaves
  space.TakeAway(3);
  EXPECT_EQ(space.At(in_the_free), Occupancy::kOccupied);
  X_WM.translation().x() += 0.25;
  space.Place(4, box, X_WM);  // moved
  EXPECT_EQ(space.At(in_the_free), Occupancy::kFree);
  EXPECT_EQ(space.At(in_the_unknown), Occupancy::kUnknown);
  EXPECT_EQ(space.At({0.255, 0.005, 1.005}), Occupancy::kOccupied);
  space.TakeAway(4);
  space.TakeAway(5);  // never stood there
  EXPECT_EQ(space.At({0.255, 0.005, 1.005}), Occupancy::kUnknown);
}

TEST(WorkspaceAbove, IsTheBoxAroundTheRectangleExtruded) {
  SupportPlane plane_W;
  plane_W.corners_A = {Vector3d(0, -1, 0.7), Vector3d(1, 0, 0.7), Vector3d(0, 1, 0.7),
                       Vector3d(-1, 0, 0.7)};
  const AlignedBox3d box_W =
      WorkspaceAbove(plane_W, {.workspace_height_m = 0.5, .workspace_margin_m = 0.1});
  EXPECT_TRUE(box_W.min().isApprox(Vector3d(-1.1, -1.1, 0.6)));
  EXPECT_TRUE(box_W.max().isApprox(Vector3d(1.1, 1.1, 1.3)));
}

TEST(VoxelSpace, RefusesBadInput) {
  VoxelSpace space;
  Pose X_WC = Pose::Identity();
  X_WC.translation().x() = NAN;
  EXPECT_THROWS(space.Insert(Wall(1.0F), kCamera, X_WC, 1), InvalidArgument, "X_WC");
  EXPECT_THROWS(space.Insert(Wall(1.0F), kCamera, Pose::Identity(), 0), InvalidArgument,
                "stride = 0");
  EXPECT_THROWS(space.Insert(cv::Mat(10, 10, CV_32FC1), kCamera, Pose::Identity(), 1),
                InvalidArgument, "10 x 10 px");
  EXPECT_THROWS(space.MarkOccupied({Vector3d::Constant(NAN)}), InvalidArgument, "not finite");
  EXPECT_THROWS(space.ClearBox(AlignedBox3d(Vector3d(0, 0, 0), Vector3d(INFINITY, 0, 0))),
                InvalidArgument, "box to clear");
  EXPECT_THROWS(VoxelSpace({}, AlignedBox3d(Vector3d(0, 0, 0), Vector3d(0, 1, 1))), InvalidArgument,
                "must be finite and have a volume");
  EXPECT_THROWS(VoxelSpace(VoxelSpaceConfig{.voxel_m = 0.0}), ConfigError, "voxel_m = 0");
  EXPECT_THROWS(VoxelSpace(VoxelSpaceConfig{.miss_probability = 0.6}), ConfigError,
                "miss_probability = 0.6");
}

}  // namespace
}  // namespace secondlook::world
