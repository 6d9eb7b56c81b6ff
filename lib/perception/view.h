#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "lib/geometry/camera_model.h"
#include "lib/geometry/point_image.h"
#include "lib/world/observation.h"
#include "lib/world/support_plane.h"

namespace secondlook::perception {

/// One frame as recognition looks at it.
struct View {
  cv::Mat color;   ///< [height, width] CV_8UC3, RGB; empty: none.
  cv::Mat depth;   ///< [height, width] CV_32FC1, z_C [m]; NaN = none.
  cv::Mat labels;  ///< [height, width] CV_32SC1: index of the pixel's cluster, -1 = none.
  geometry::CameraModel camera;
  world::SupportPlane plane_C;                 ///< In the camera frame.
  std::vector<world::SupportPlane> further_C;  ///< Others that things may stand on.

  /// The plane that a thing at p_CQ stands on: of those that reach under it, the highest below it;
  /// plane_C when none does.
  const world::SupportPlane& PlaneUnder(const Eigen::Vector3d& p_CQ) const;
};

/// The view of `color` (may be empty) and `depth` that holds `clusters`, which stand on `plane_C`
/// or on one of `further_C`.
/// @throws InvalidArgument when an image does not fit `camera` or is of another type, or a cluster
/// has a pixel outside the image.
View MakeView(const cv::Mat& color, const cv::Mat& depth, const geometry::CameraModel& camera,
              const world::SupportPlane& plane_C, const std::vector<world::Cluster>& clusters,
              const std::vector<world::SupportPlane>& further_C = {});

/// How far [m] a measurement at depth `z` may lie from the rendered surface and still be of it:
/// 2.5 sigma of the sensor and 4 mm for the error of pose and model.
inline double DepthTolerance(double z) { return 0.004 + 2.5 * geometry::DepthSigma(z); }

}  // namespace secondlook::perception
