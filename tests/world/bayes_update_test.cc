#include "lib/world/bayes_update.h"

#include <limits>

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::world {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr geometry::CameraModel kCamera{64, 48, 60.0, 60.0, 31.5, 23.5};
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

AlignedBox3d Cube(double half) { return {Vector3d::Constant(-half), Vector3d::Constant(half)}; }

cv::Mat Wall(float z) { return {kCamera.height, kCamera.width, CV_32FC1, cv::Scalar(z)}; }

/// A rough surface, 0.5 to 1.4 m away, with holes.
cv::Mat RandomDepth(Rng* rng) {
  cv::Mat depth = Wall(1.0F);
  const double wave = rng->Uniform(0.02, 0.2);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      depth.at<float>(v, u) =
          rng->Uniform(0, 1) < 0.05
              ? kNan
              : static_cast<float>(0.95 + 0.4 * std::sin(wave * u) + 0.01 * (v - 24) / 5.0);
    }
  }
  return depth;
}

Pose RandomPose(Rng* rng) {
  const auto draw = [&](double reach) {
    return Vector3d(rng->Uniform(-reach, reach), rng->Uniform(-reach, reach),
                    rng->Uniform(-reach, reach));
  };
  Pose X_WC = Pose::Identity();
  X_WC.linear() = RotationFromVector(draw(2.0));
  X_WC.translation() = draw(0.5);
  return X_WC;
}

/// OctoMap's own insertion of the same points.
void InsertInOctoMap(const cv::Mat& depth, const Pose& X_WC, octomap::OcTree* tree) {
  const auto to_octomap = [](const Vector3d& p) {
    return octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()),
                            static_cast<float>(p.z()));
  };
  octomap::Pointcloud cloud;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const double z = depth.at<float>(v, u);
      if (z > 0.0) cloud.push_back(to_octomap(X_WC * (kCamera.Ray(u, v) * z)));
    }
  }
  tree->insertPointCloud(cloud, to_octomap(X_WC.translation()), -1.0, false, true);
}

TEST(EnterDepth, GivesOctoMapsLogOddsOverSeveralViews) {
  Rng rng(5);
  for (int trial = 0; trial < 4; ++trial) {
    BrickGrid grid(0.02, Cube(3.0));
    octomap::OcTree tree(0.02);
    for (int view = 0; view < 3; ++view) {
      const cv::Mat depth = RandomDepth(&rng);
      const Pose X_WC = RandomPose(&rng);
      EnterDepth(depth, kCamera, X_WC, {}, &grid);
      InsertInOctoMap(depth, X_WC, &tree);
    }
    int same = 0;
    int known = 0;
    for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
      const Vector3d p(leaf.getX(), leaf.getY(), leaf.getZ());
      ++known;
      const auto ours = grid.ProbabilityAt(p);
      same += ours && std::abs(*ours - leaf->getOccupancy()) < 1e-4 ? 1 : 0;
    }
    ASSERT_GT(known, 5000);
    // OctoMap computes in single precision, so a ray that grazes a voxel's edge may differ.
    EXPECT_GT(static_cast<double>(same) / known, 0.99) << "trial " << trial;
  }
}

TEST(EnterDepth, InASmallGridSaysWhatALargeOneSaysThere) {
  Rng rng(6);
  for (int trial = 0; trial < 5; ++trial) {
    BrickGrid large(0.02, Cube(4.0));
    BrickGrid small(0.02, Cube(0.4));
    const cv::Mat depth = RandomDepth(&rng);
    const Pose X_WC = RandomPose(&rng);
    EnterDepth(depth, kCamera, X_WC, {}, &large);
    EnterDepth(depth, kCamera, X_WC, {}, &small);
    int occupied = 0;
    int known = 0;
    int same = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vector3d p(rng.Uniform(-0.4, 0.4), rng.Uniform(-0.4, 0.4), rng.Uniform(-0.4, 0.4));
      const Occupancy there = large.At(p);
      if (there == Occupancy::kOccupied || small.At(p) == Occupancy::kOccupied) {
        EXPECT_EQ(small.At(p), there);
        ++occupied;
      }
      known += there != Occupancy::kUnknown ? 1 : 0;
      same += small.At(p) == there ? 1 : 0;
    }
    // Rays that end outside are followed to the voxel where they leave, not to where they end.
    EXPECT_GT(same, 0.97 * 20000) << "trial " << trial << ", " << known << " known";
  }
}

TEST(EnterDepth, ClampsAsOctoMapDoes) {
  BrickGrid grid(0.02, Cube(2.0));
  for (int i = 0; i < 20; ++i) EnterDepth(Wall(1.01F), kCamera, Pose::Identity(), {}, &grid);
  EXPECT_NEAR(grid.ProbabilityAt({0.01, 0.01, 1.01}).value(), 0.971, 1e-6);
  EXPECT_NEAR(grid.ProbabilityAt({0.01, 0.01, 0.51}).value(), 0.1192, 1e-6);
}

TEST(EnterDepth, CountsTheBricksThatChangeAndNoneWhenAllIsSure) {
  BrickGrid grid(0.02, Cube(2.0));
  EXPECT_GT(EnterDepth(Wall(1.01F), kCamera, Pose::Identity(), {}, &grid), 100);
  for (int i = 0; i < 20; ++i) EnterDepth(Wall(1.01F), kCamera, Pose::Identity(), {}, &grid);
  EXPECT_EQ(EnterDepth(Wall(1.01F), kCamera, Pose::Identity(), {}, &grid), 0);
}

TEST(EnterDepth, APixelWithoutReturnSaysNothingOrFreesItsWay) {
  for (const float none : {kNan, 0.0F, -1.0F, std::numeric_limits<float>::infinity()}) {
    BrickGrid grid(0.02, Cube(2.0));
    EXPECT_EQ(EnterDepth(Wall(none), kCamera, Pose::Identity(), {}, &grid), 0);
    EXPECT_EQ(grid.At({0.01, 0.01, 0.5}), Occupancy::kUnknown);
    DepthUpdate update;
    update.no_return = NoReturn::kFreeToRange;
    update.max_range_m = 1.0;
    EnterDepth(Wall(none), kCamera, Pose::Identity(), update, &grid);
    EXPECT_EQ(grid.At({0.01, 0.01, 0.95}), Occupancy::kFree);
    EXPECT_EQ(grid.At({0.01, 0.01, 1.05}), Occupancy::kUnknown);
  }
}

TEST(EnterDepth, AGridThatNoRayMeetsStaysAsItIs) {
  BrickGrid grid(0.02, AlignedBox3d(Vector3d(5, 5, 5), Vector3d(6, 6, 6)));
  EXPECT_EQ(EnterDepth(Wall(1.0F), kCamera, Pose::Identity(), {}, &grid), 0);
  EXPECT_EQ(grid.revision(), 0U);
}

TEST(EnterDepth, RefusesBadInput) {
  BrickGrid grid(0.02, Cube(1.0));
  const Pose X_WC = Pose::Identity();
  EXPECT_THROWS(EnterDepth(cv::Mat(10, 10, CV_32FC1), kCamera, X_WC, {}, &grid), InvalidArgument,
                "10 x 10 px");
  EXPECT_THROWS(EnterDepth(cv::Mat(48, 64, CV_16UC1), kCamera, X_WC, {}, &grid), InvalidArgument,
                "CV_32FC1");
  DepthUpdate update;
  update.max_range_m = 0.0;
  EXPECT_THROWS(EnterDepth(Wall(1.0F), kCamera, X_WC, update, &grid), InvalidArgument,
                "the range 0 m");
  update = {};
  update.model.hit_probability = 0.4;
  EXPECT_THROWS(EnterDepth(Wall(1.0F), kCamera, X_WC, update, &grid), InvalidArgument, "hit 0.4");
}

}  // namespace
}  // namespace secondlook::world
