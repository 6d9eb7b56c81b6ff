#pragma once

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/planning/tile_scores.h"

namespace secondlook::planning {

/// The camera pose X_CV that looks at an object from the side of `tile` (Hoseini 2021, Section 4):
/// at the object's depth in the camera frame C of the first view, `distance` [m] from its middle
/// `p_CO` [m], that on the optical axis. Its image is upright in C's, seen from top and bottom with
/// what is far from C up and down.
/// @throws InvalidArgument for an object that is not before C, or a distance that is not positive.
Pose TileView(Tile tile, const Eigen::Vector3d& p_CO, double distance);

}  // namespace secondlook::planning
