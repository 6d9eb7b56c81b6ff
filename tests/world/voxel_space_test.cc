#include "lib/world/voxel_space.h"

#include <filesystem>
#include <limits>

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
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
  EXPECT_EQ(space.LikelyFreeShare({{0, 0, 0}}), 0.0);
  EXPECT_EQ(space.LikelyFreeShare({}), 0.0);
  EXPECT_TRUE(space.Occupied(AlignedBox3d(Vector3d(-1, -1, -1), Vector3d(1, 1, 1))).empty());
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
  int known = 0;
  space.Visit(AlignedBox3d(Vector3d(-9, -9, -9), Vector3d(9, 9, 9)),
              [&](const Voxel&) { ++known; });
  EXPECT_EQ(known, 0);
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
  double hit = 0.0;
  double miss = 1.0;
  space.Visit(AlignedBox3d(Vector3d(-0.1, -0.1, 0.1), Vector3d(0.1, 0.1, 1.1)),
              [&](const Voxel& voxel) {
                hit = std::max(hit, voxel.probability);
                miss = std::min(miss, voxel.probability);
              });
  EXPECT_NEAR(hit, 0.7, 1e-6);
  EXPECT_NEAR(miss, 0.4, 1e-6);
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

/// The same map by OctoMap's own insertion.
octomap::OcTree Reference(const cv::Mat& depth, const Pose& X_WC) {
  octomap::OcTree tree(0.02);
  octomap::Pointcloud cloud;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const Vector3d p = X_WC * (kCamera.Ray(u, v) * depth.at<float>(v, u));
      cloud.push_back(static_cast<float>(p.x()), static_cast<float>(p.y()),
                      static_cast<float>(p.z()));
    }
  }
  const Vector3d o = X_WC.translation();
  tree.insertPointCloud(
      cloud, {static_cast<float>(o.x()), static_cast<float>(o.y()), static_cast<float>(o.z())},
      -1.0, false, true);
  return tree;
}

TEST(VoxelSpace, AgreesWithOctoMapsOwnInsertion) {
  Rng rng(5);
  for (int trial = 0; trial < 3; ++trial) {
    cv::Mat depth = Wall(1.0F);
    for (int v = 0; v < depth.rows; ++v) {
      for (int u = 0; u < depth.cols; ++u) {
        depth.at<float>(v, u) = static_cast<float>(0.8 + 0.3 * std::sin(0.1 * u) + 0.01 * v);
      }
    }
    Pose X_WC = Pose::Identity();
    X_WC.linear() = RotationFromVector(RandomPoint(&rng, 1.0));
    X_WC.translation() = RandomPoint(&rng, 0.5);
    VoxelSpace space;
    space.Insert(depth, kCamera, X_WC, 1);
    octomap::OcTree tree = Reference(depth, X_WC);
    int same = 0;
    int all = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vector3d p =
          X_WC * (kCamera.Ray(rng.Uniform(0, 63), rng.Uniform(0, 47)) * rng.Uniform(0.05, 1.5));
      const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
      const Occupancy expected = node == nullptr             ? Occupancy::kUnknown
                                 : tree.isNodeOccupied(node) ? Occupancy::kOccupied
                                                             : Occupancy::kFree;
      ++all;
      if (space.At(p) == expected) ++same;
    }
    // OctoMap computes in single precision, so a ray that grazes a voxel's edge may differ.
    EXPECT_GT(static_cast<double>(same) / all, 0.995) << "trial " << trial;
    EXPECT_EQ(space.octree().getTreeDepth(), 16U);
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
  EXPECT_EQ(space.Occupied(AlignedBox3d(Vector3d(-1, -1, -1), Vector3d(1, 1, 1))).size(), 2U);
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
  double hit = 0.0;
  copy.Visit(AlignedBox3d(Vector3d(0, 0, 1.0), Vector3d(0.02, 0.02, 1.02)),
             [&](const Voxel& voxel) { hit = std::max(hit, voxel.probability); });
  EXPECT_NEAR(hit, 0.9, 1e-6);  // the copy has the config, too
}

TEST(VoxelSpace, AFileGivesBackTheMap) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "voxel_space_test";
  VoxelSpace space;
  space.Insert(Wall(1.01F), kCamera, Pose::Identity(), 2);
  for (const char* name : {"map.ot", "map.bt"}) {
    space.Save(folder / name);
    VoxelSpace read;
    read.Load(folder / name);
    Rng rng(7);
    for (int i = 0; i < 2000; ++i) {
      const Vector3d p(rng.Uniform(-0.6, 0.6), rng.Uniform(-0.5, 0.5), rng.Uniform(0, 1.2));
      EXPECT_EQ(read.At(p), space.At(p)) << name;
    }
  }
  VoxelSpace fine(VoxelSpaceConfig{.voxel_m = 0.01});
  EXPECT_THROWS(fine.Load(folder / "map.bt"), ConfigError, "set voxel_m to match");
  WriteFile(folder / "no_map.bt", "hello");
  EXPECT_THROWS(fine.Load(folder / "no_map.bt"), ConfigError, "no octree");
  EXPECT_THROWS(fine.Load(folder / "missing.ot"), ConfigError, "missing.ot");
  EXPECT_THROWS(space.Save(folder / "map.txt"), ConfigError, "ends in .bt or .ot, not in '.txt'");
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
  EXPECT_THROWS(VoxelSpace(VoxelSpaceConfig{.voxel_m = 0.0}), ConfigError, "voxel_m = 0");
  EXPECT_THROWS(VoxelSpace(VoxelSpaceConfig{.miss_probability = 0.6}), ConfigError,
                "miss_probability = 0.6");
}

}  // namespace
}  // namespace secondlook::world
