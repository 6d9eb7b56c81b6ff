#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/world/brick_grid.h"
#include "lib/world/leap_field.h"

namespace secondlook::world {

/// The part of the straight line from A to B that lies in the box, in shares of its length: from
/// the first to the second; none when the first is not smaller.
std::pair<double, double> ShareInside(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& p_A,
                                      const Eigen::Vector3d& p_B);

/// What ends a ray.
enum class RayStop {
  kOccupied,          ///< The first occupied voxel. Free and unknown are passed alike.
  kOccupiedOrUnknown  ///< The first voxel that is not free.
};

/// Where a ray ends.
struct RayEnd {
  Occupancy state{Occupancy::kFree};  ///< Of the voxel that ends it; kFree: nothing does.
  VoxelKey voxel{VoxelKey::Zero()};   ///< The voxel that ends it.
  double at{};       ///< How far along it enters that voxel, or all of it, in lengths of the ray.
  double unknown{};  ///< How much of it up to there is unknown, when asked for; same unit.
};

/// Rays are followed by leaps from one empty cube to the next (Amanatides and Woo 1987 where the
/// cube is a voxel). What lies out of the grid is passed and not counted as unknown. A ray that
/// touches an edge of a voxel may or may not count as entering it.

/// Follows the straight line from A to B, the voxel around A included. Its length is the unit.
/// @param leaps Refreshed after the grid's last change.
/// @pre A and B are finite.
RayEnd CastRay(const BrickGrid& grid, const LeapField& leaps, const Eigen::Vector3d& p_WA,
               const Eigen::Vector3d& p_WB, RayStop stop = RayStop::kOccupied);

/// As CastRay() up to the first occupied voxel, and measures the unknown on the way.
RayEnd CastRayThroughUnknown(const BrickGrid& grid, const LeapField& leaps,
                             const Eigen::Vector3d& p_WA, const Eigen::Vector3d& p_WB);

/// The rays of some of a camera's pixels. Along each, depth z_C is the unit.
struct RayFan {
  geometry::CameraModel camera;
  Pose X_WC;
  Eigen::Vector2i first{Eigen::Vector2i::Zero()};  ///< Column and row of the first pixel.
  Eigen::Vector2i size{Eigen::Vector2i::Zero()};   ///< Columns and rows of pixels.
  std::vector<double> depth;  ///< How far the ray of each pixel goes, row by row; 0: not cast.
};

/// As CastRay() for every pixel, in the order of `fan.depth`. Rays side by side are followed
/// together as one beam as long as it fits into the empty cubes, and in quarters of it from there.
/// @throws InvalidArgument when `fan.depth` is not of the fan's size.
std::vector<RayEnd> CastFan(const BrickGrid& grid, const LeapField& leaps, const RayFan& fan);
std::vector<RayEnd> CastFanThroughUnknown(const BrickGrid& grid, const LeapField& leaps,
                                          const RayFan& fan);

}  // namespace secondlook::world
