#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "lib/geometry/camera_model.h"
#include "lib/perception/explain.h"

namespace secondlook::perception {

/// Compares points that were measured before with the depth of a view from `X_WC`, as
/// CompareSurface() does with a model: a point in front of what its pixel measures by more than 30
/// mm is seen through. Points out of the picture, without a measurement, or behind what is measured
/// say nothing.
/// @param depth [height, width] CV_32FC1, z_C [m]; NaN = none.
SurfaceAgreement ComparePoints(const std::vector<Eigen::Vector3d>& points_W, const Pose& X_WC,
                               const cv::Mat& depth, const geometry::CameraModel& camera);

}  // namespace secondlook::perception
