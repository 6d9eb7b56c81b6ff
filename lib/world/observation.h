#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/hal/camera.h"
#include "lib/world/hypothesis.h"
#include "lib/world/mass_function.h"
#include "lib/world/support_plane.h"

namespace secondlook::world {

/// One thing that stands on a support plane, as one view shows it.
struct Cluster {
  std::vector<int> pixels;                ///< Row-major indices into the frame, ascending.
  std::vector<Eigen::Vector3d> points_C;  ///< One per pixel, camera frame [m].
  Eigen::Vector3d center_C{Eigen::Vector3d::Zero()};  ///< Mean of the points [m].
  bool touches_border{};                              ///< The image cuts it off.
};

/// What one view says of one thing.
struct Detection {
  Cluster cluster;
  /// Ordered by falling score. At most a few per model; look-alikes and turned poses each have
  /// theirs. Empty when no model fits at all.
  std::vector<Hypothesis> hypotheses;
  /// Why there is no accepted hypothesis: the nearest miss, with values. Empty when there is one.
  std::string reason;
  /// What its picture says of its class, whatever its shape; nothing without a classifier.
  MassFunction appearance;
};

/// One view.
struct Observation {
  hal::RgbdFrame frame;
  hal::CameraModel camera;
  Pose X_WC{Pose::Identity()};  ///< At the time of measurement, registered to the map.
  SupportPlane plane_C;         ///< In the camera frame.
  std::vector<Detection> detections;
};

}  // namespace secondlook::world
