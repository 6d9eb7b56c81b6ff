#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/world/range_scan.h"

namespace secondlook::world {

/// A small piece of the surface that a scan shows.
struct ScanPatch {
  Eigen::Vector3d p_W;       ///< The mean of its points [m].
  Eigen::Vector3d normal_W;  ///< Unit, towards the sensor.
  double sigma{};            ///< The mean of its points' [m].
};

/// A scan cut into patches.
struct ScanPatches {
  std::vector<ScanPatch> patches;  ///< Ordered by place.
  std::vector<int> of_point;       ///< The patch of each point of the scan.
};

/// Cuts a scan into the cells of a grid. The normal of a cell is that of the plane through its
/// points and those of the six cells beside it; of a wire, which is a line rather than a plane, and
/// of single points the direction to the sensor, upright on the line.
/// @throws InvalidArgument as Check(), or unless cell > 0 [m].
ScanPatches CutIntoPatches(const RangeScan& scan, double cell);

}  // namespace secondlook::world
