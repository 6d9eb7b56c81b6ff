#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "lib/geometry/camera_model.h"
#include "lib/geometry/sampling.h"

namespace secondlook::geometry {

/// How the plane around a pixel is fitted.
struct NormalOptions {
  double radius = 0.007;    ///< Of the window on the surface [m], plus…
  double per_sigma = 3.0;   ///< …this many sigma of the depth noise.
  double gate_sigma = 3.0;  ///< A neighbour farther from the centre in depth than the window is…
  int min_points = 8;       ///< …wide plus so many sigma is another surface. Fewer: no normal.
};

/// The local plane at `pixel` (row-major) of `depth` [m, CV_32FC1, NaN = none] as an oriented point
/// in C: the pixel's point moved along its ray onto the plane, the normal facing the camera. The
/// plane is z^-1 as a linear function of the pixel, fitted twice: the second time without what lies
/// more than 3 sigma off the first. `labels`, when not empty, is one int (CV_32SC1) per pixel;
/// only pixels with the centre's label count. Empty where nothing is measured or too few
/// neighbours are left.
std::optional<OrientedPoint> FitLocalPlane(const cv::Mat& depth, const cv::Mat& labels,
                                           const CameraModel& camera, int pixel,
                                           const NormalOptions& options = {});

}  // namespace secondlook::geometry
