#pragma once

#include <span>

#include "lib/common/pose_history.h"
#include "lib/hal/laser_striper.h"
#include "lib/world/range_scan.h"

namespace secondlook::perception {

/// How well the pose of a laser is known, alike for all lines of a sweep.
struct LaserPrecision {
  double position_sigma{0.0015};  ///< [m], >= 0.
  double rotation_sigma{0.004};   ///< About each axis [rad], >= 0.
};

/// The points that `lines` measured, in W: each line from where the laser was at its own time.
/// A line without any return is one without points.
/// @param X_WL Covers the times of all lines.
/// @throws InvalidArgument for a line that it does not cover, as no pose is extrapolated, or that
/// has not a range for each ray of the striper.
world::RangeScan StripedScan(std::span<const hal::ScanLine> lines, const hal::StriperInfo& striper,
                             const PoseHistory& X_WL, const LaserPrecision& precision = {});

}  // namespace secondlook::perception
