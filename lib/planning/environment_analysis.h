#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/planning/aspect_graph_config.h"
#include "lib/world/voxel_space.h"

namespace secondlook::planning {

/// A ray of the modelled camera that meets the target's box.
struct BoxRay {
  Eigen::Vector3d direction_W;  ///< 1 along the optical axis, so distances are depths.
  double chance{};              ///< To arrive at the box, in [0, 1]; 0: stopped.
  bool stopped{};
  bool through_unknown{};
};

/// The rays of a modelled camera that meet a target's box, row by row, and what becomes of them.
struct BoxRays {
  std::vector<BoxRay> rays;
  double blocked{};          ///< Share of these that an occupied voxel stops.
  double through_unknown{};  ///< Share that is not stopped but crosses unknown space.
  double surviving{};        ///< Share that arrives, with the chance to survive.
};

/// The environment analysis of one candidate (McGreavy 2016, Section 4): the rays of `camera` at
/// X_WC that meet `box_W` are cast through `space`. A voxel within `box_margin_m` beside or above
/// the box may be the target itself and stops none.
BoxRays CastToBox(const world::VoxelSpace& space, const geometry::CameraModel& camera,
                  const Pose& X_WC, const Eigen::AlignedBox3d& box_W,
                  const AspectGraphConfig& config);

}  // namespace secondlook::planning
