#pragma once

#include <filesystem>

#include <Eigen/Geometry>

#include "lib/world/brick_grid.h"

namespace octomap {
class OcTree;
}

namespace secondlook::world {

/// The grid as an octree with the same voxels: every voxel that is not unknown, pruned. What stands
/// there as a model is occupied with probability 0.971.
/// @throws InvalidArgument when the grid reaches out of OctoMap's +-32,768 voxels.
octomap::OcTree ToOctree(const BrickGrid& grid);

/// The occupied voxels whose bricks reach into `box_W` alone, e.g. for collision checks by FCL.
octomap::OcTree OccupiedOctree(const BrickGrid& grid, const Eigen::AlignedBox3d& box_W);

/// A grid that holds the octree's voxels. @throws InvalidArgument when that would be larger than a
/// BrickGrid may be or than 2^30 voxels, or the tree is empty.
BrickGrid FromOctree(const octomap::OcTree& tree);

/// Writes the grid as an OctoMap file, all or nothing: `.ot` with all probabilities, `.bt` with
/// free and occupied alone. @throws ConfigError for another suffix or when it cannot be written.
void SaveMap(const BrickGrid& grid, const std::filesystem::path& file);

/// Reads a file that SaveMap() or OctoMap has written.
/// @throws ConfigError naming the file: missing, of another suffix, not an octree, damaged, empty,
/// too large, or of another voxel size than `voxel_m`.
BrickGrid LoadMap(const std::filesystem::path& file, double voxel_m);

}  // namespace secondlook::world
