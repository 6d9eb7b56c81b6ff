#pragma once

#include <opencv2/core/mat.hpp>

#include "lib/geometry/camera_model.h"

namespace secondlook::geometry {

/// Brown and Conrady's lens distortion, with OpenCV's meaning of the five coefficients.
struct LensDistortion {
  double k1{}, k2{}, p1{}, p2{}, k3{};

  bool none() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }

  /// Where the ray (x, y, 1) of the undistorted image falls, in the same normalised units.
  Eigen::Vector2d Distort(const Eigen::Vector2d& xy) const;
};

/// `image` as a lens without distortion had taken it. Colour (CV_8UC3) is interpolated; depth
/// (CV_32FC1) takes the nearest pixel, as a mean across an edge is no depth. What falls outside is
/// black or NaN. @throws InvalidArgument for another type or a size that does not fit `camera`.
cv::Mat Undistort(const cv::Mat& image, const CameraModel& camera, const LensDistortion& lens);

}  // namespace secondlook::geometry
