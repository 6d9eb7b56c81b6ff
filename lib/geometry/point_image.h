#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "lib/geometry/camera_model.h"

namespace secondlook::geometry {

/// A point cloud in the order of an image, camera frame C [m]; NaN in all three = none. A cloud
/// without that order has height 1.
struct PointImage {
  int width{};
  int height{};
  std::vector<Eigen::Vector3f> points_C;  ///< Row-major, width * height.

  bool organised() const { return height > 1; }
};

/// True when all three coordinates are finite.
inline bool IsMeasured(const Eigen::Vector3f& p) { return p.allFinite(); }

/// The points of a depth image (CV_32FC1, z_C [m], NaN = none).
/// @throws InvalidArgument when the image's type or size does not fit the camera.
PointImage Deproject(const cv::Mat& depth, const CameraModel& camera);

/// The standard deviation [m] along the optical axis of a Kinect-class depth camera at depth `z`
/// [m] (Nguyen, Izadi and Lovell 2012, Eq. 1): 1.2 mm + 1.9 mm/m^2 (z - 0.4 m)^2.
inline double DepthSigma(double z) { return 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4); }

}  // namespace secondlook::geometry
