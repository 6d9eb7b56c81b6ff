#pragma once

#include <opencv2/core/mat.hpp>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/world/brick_grid.h"

namespace secondlook::world {

/// What one depth measurement says of the voxels along its ray. The defaults are OctoMap's.
struct OccupancyModel {
  double hit_probability{0.7};     ///< p(occupied | a ray ends in the voxel), in (0.5, 1).
  double miss_probability{0.4};    ///< p(occupied | a ray passes through it), in (0, 0.5).
  double min_probability{0.1192};  ///< A voxel is never thought more free than this …
  double max_probability{0.971};   ///< … nor more occupied.
};

/// What a pixel without a return says.
enum class NoReturn {
  kNothing,     ///< Dark, shiny and too near surfaces return nothing, too.
  kFreeToRange  ///< Nothing is there up to the range. Only for a sensor that sees every surface in
                ///< range, and an image whose masked pixels (the robot's own arm) are left out.
};

/// How a depth image is entered.
struct DepthUpdate {
  OccupancyModel model;
  double max_range_m{3.0};  ///< Rays are cut off there; what they hit beyond is not entered.
  NoReturn no_return{NoReturn::kNothing};
  int stride{1};  ///< Every stride-th pixel of every stride-th row is used.
};

/// Enters a depth image by Bayes' rule (Kriegel 2013, III-A; Hornung et al. 2013, OctoMap): voxels
/// in which a ray ends become more probably occupied, those it passes more probably free. Each
/// voxel is updated once however many rays there are, a hit before a miss. End points are
/// discretised first: one ray is followed to the centre of each voxel that holds some. A ray that
/// leaves the grid or the range is followed to where it does and hits nothing.
/// Returns how many bricks were changed.
/// @param depth [height, width] CV_32FC1, z_C [m]; NaN, infinite or <= 0: no return.
/// @throws InvalidArgument for a depth image of another type or size than the camera's, a pose that
/// is not rigid and finite, a stride below 1, a range that is not positive, or probabilities that
/// are not in order.
int EnterDepth(const cv::Mat& depth, const geometry::CameraModel& camera, const Pose& X_WC,
               const DepthUpdate& update, BrickGrid* grid);

}  // namespace secondlook::world
