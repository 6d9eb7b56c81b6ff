#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include <octomap/OcTree.h>

#include "lib/common/rng.h"
#include "lib/geometry/point_image.h"
#include "lib/world/bayes_update.h"
#include "tests/support/analytic_scene.h"

namespace secondlook::bench {

inline constexpr geometry::CameraModel kCamera{640, 480, 577.0, 577.0, 319.5, 239.5};
inline constexpr double kVoxel_m = 0.01;

/// The workspace above the table: 1.5 x 1.0 x 0.8 m.
inline Eigen::AlignedBox3d Workspace() {
  return {Eigen::Vector3d(-0.75, -0.5, 0.7), Eigen::Vector3d(0.75, 0.5, 1.5)};
}

/// A table with ten things on it, above a floor.
inline testing::AnalyticScene Clutter() {
  testing::AnalyticScene scene;
  Pose X_WT = Pose::Identity();
  X_WT.translation().z() = 0.735;
  scene.boxes.push_back({X_WT, {1.2, 0.8, 0.03}});
  Rng rng(11);
  for (int i = 0; i < 10; ++i) {
    const double x = -0.45 + 0.225 * (i % 5) + rng.Uniform(-0.04, 0.04);
    const double y = (i < 5 ? -0.18 : 0.18) + rng.Uniform(-0.06, 0.06);
    const double height = rng.Uniform(0.08, 0.28);
    if (i % 2 == 0) {
      Pose X_WA = Pose::Identity();
      X_WA.linear() = RotationFromRollPitchYaw(0, 0, rng.Uniform(0, std::numbers::pi));
      X_WA.translation() << x, y, 0.75 + 0.5 * height;
      scene.boxes.push_back({X_WA, {rng.Uniform(0.05, 0.15), rng.Uniform(0.04, 0.1), height}});
    } else {
      scene.cylinders.push_back({{x, y, 0.75}, rng.Uniform(0.03, 0.06), height});
    }
  }
  return scene;
}

/// A depth image and where it was taken.
struct Frame {
  cv::Mat depth;  ///< [480, 640] CV_32FC1 [m], with the axial noise of a depth camera.
  Pose X_WC;
};

/// `count` frames from around the table, 1.3 m away and 35 degrees above it.
inline std::vector<Frame> Frames(const testing::AnalyticScene& scene, int count) {
  std::vector<Frame> frames;
  Rng rng(5);
  for (int i = 0; i < count; ++i) {
    const double azimuth = 2.0 * std::numbers::pi * i / count;
    const Eigen::Vector3d target(0, 0, 0.8);
    const Eigen::Vector3d from(1.06 * std::cos(azimuth), 1.06 * std::sin(azimuth), 0.75);
    const Pose X_WC = testing::LookingAt(target + from, target);
    cv::Mat depth = scene.Render(kCamera, X_WC);
    for (auto z = depth.begin<float>(); z != depth.end<float>(); ++z) {
      *z += static_cast<float>(rng.Gaussian(geometry::DepthSigma(*z)));
    }
    frames.push_back({depth, X_WC});
  }
  return frames;
}

/// Every ray is followed to its end.
inline world::DepthUpdate Update() {
  world::DepthUpdate update;
  update.max_range_m = 10.0;
  return update;
}

inline octomap::point3d ToOctomap(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/// The frame's points in W, as OctoMap takes them.
inline octomap::Pointcloud Cloud(const Frame& frame) {
  octomap::Pointcloud cloud;
  for (int v = 0; v < frame.depth.rows; ++v) {
    for (int u = 0; u < frame.depth.cols; ++u) {
      const double z = frame.depth.at<float>(v, u);
      if (z > 0.0) cloud.push_back(ToOctomap(frame.X_WC * (kCamera.Ray(u, v) * z)));
    }
  }
  return cloud;
}

/// An octree that enters only what ends in the workspace.
inline octomap::OcTree CroppedOctree() {
  octomap::OcTree tree(kVoxel_m);
  octomap::point3d low = ToOctomap(Workspace().min());
  octomap::point3d high = ToOctomap(Workspace().max());
  tree.setBBXMin(low);
  tree.setBBXMax(high);
  tree.useBBXLimit(true);
  return tree;
}

}  // namespace secondlook::bench
