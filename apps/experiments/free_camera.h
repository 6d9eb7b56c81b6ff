#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "lib/common/pose.h"
#include "lib/common/rng.h"
#include "lib/hal/camera.h"
#include "sim/scene_renderer.h"
#include "sim/sim_robot.h"

namespace secondlook::apps {

/// A frame that a FreeCamera took, and the truth of it.
struct Photo {
  hal::RgbdFrame frame;  ///< With the simulated camera's errors.
  Pose X_WC{Pose::Identity()};
  cv::Mat id;           ///< sim::Render::id.
  cv::Mat clean_depth;  ///< sim::Render::depth.
};

/// A camera that looks at `target_W` from 0.6 to 1.2 m, 20 to 70 degrees above it, from any side.
Pose DrawView(const Eigen::Vector3d& target_W, Rng* rng);

/// The simulated robot's camera, without the robot: held anywhere in a scene.
class FreeCamera {
 public:
  /// All its errors are drawn from `seed`, the frames one after the other.
  /// @throws ConfigError naming the object whose mesh cannot be read, or the wrong noise.
  FreeCamera(const sim::Scene& scene, std::uint64_t seed);

  const hal::CameraInfo& info() const { return info_; }
  const sim::World& world() const { return *robot_.world; }

  Photo Take(const Pose& X_WC);

  /// For each object the share in [0, 1] of its silhouette that `photo` shows: not hidden by
  /// another, inside the picture, and where the depth camera measures.
  std::vector<double> VisibleShares(const Photo& photo);

 private:
  sim::SimulatedRobot robot_;
  hal::CameraInfo info_;
  sim::SceneRenderer renderer_;
  sim::SceneRenderer wide_renderer_;  // sees what the picture cuts off, too
  Rng rng_;
  std::uint64_t taken_{};
};

}  // namespace secondlook::apps
