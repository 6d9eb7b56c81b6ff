#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "lib/geometry/camera_model.h"
#include "lib/perception/explain.h"

namespace secondlook::perception {

/// Compares points that were measured before with the depth of a view from `X_WC`, as
/// CompareSurface() does with a model. A point is seen through when all the pixels within 10 mm of
/// it are measured more than 30 mm behind it: thin things, and those that return little, seldom hit
/// the same pixel twice. Points out of the picture, beside a pixel without a measurement, or behind
/// what is measured say nothing.
/// @param depth [height, width] CV_32FC1, z_C [m]; NaN = none.
SurfaceAgreement ComparePoints(const std::vector<Eigen::Vector3d>& points_W, const Pose& X_WC,
                               const cv::Mat& depth, const geometry::CameraModel& camera);

}  // namespace secondlook::perception
