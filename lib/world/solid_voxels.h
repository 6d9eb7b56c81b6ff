#pragma once

#include <vector>

#include "lib/common/pose.h"
#include "lib/geometry/mesh.h"
#include "lib/world/brick_grid.h"

namespace secondlook::world {

/// The voxels of a solid: those its surface passes, and those from which no way leads out past them
/// (flood fill from outside). The inside of a cup is not part of it; holes smaller than a voxel are
/// closed. Ascending by z, y, x.
/// @param voxel_m Edge [m] > 0; the voxels are those of a BrickGrid.
/// @throws InvalidArgument when the pose is not finite and rigid or the model is empty or wider
/// than 512 voxels.
std::vector<VoxelKey> SolidVoxels(const geometry::Mesh& mesh, const Pose& X_WM, double voxel_m);

}  // namespace secondlook::world
