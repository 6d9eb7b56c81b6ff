#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "lib/geometry/camera_model.h"
#include "lib/geometry/shape.h"

namespace secondlook::perception {

/// Takes the robot's own body out of a depth image: what was measured within `margin` [m] of one of
/// its solids becomes NaN, no measurement. The margin covers the errors of joints, calibration and
/// depth. What is seen past the body, in front of it or behind, stays.
/// @param body_C The solids in the camera frame, at the time of the frame.
/// @param depth [height, width] CV_32FC1, z_C [m]; NaN = none. A copy is returned; an image without
/// any pixel stays one.
/// @throws InvalidArgument for a depth image of another type or size than the camera's, or a margin
/// that is negative or not finite.
cv::Mat WithoutOwnBody(const cv::Mat& depth, const geometry::CameraModel& camera,
                       const std::vector<geometry::PlacedShape>& body_C, double margin);

}  // namespace secondlook::perception
