#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "lib/world/support_plane.h"
#include "lib/world/voxel_space.h"

namespace secondlook::planning {

struct HiddenSpaceConfig {
  double cell_m = 0.03;        ///< Of the grid on the support plane.
  double height_m = 0.04;      ///< Above the plane, where it is asked whether a thing could stand.
  double clearance_m = 0.03;   ///< What lies so near to a known thing is its own shadow.
  double min_area_m2 = 0.008;  ///< A smaller hidden region could hide nothing of interest.
  double box_height_m = 0.12;  ///< Of the boxes that are returned.

  template <class A>
  void Serialize(A* a) {
    a->Visit("cell_m", &cell_m);
    a->Visit("height_m", &height_m);
    a->Visit("clearance_m", &clearance_m);
    a->Visit("min_area_m2", &min_area_m2);
    a->Visit("box_height_m", &box_height_m);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// Where on the support plane a thing could still stand unseen: connected regions of its rectangle
/// over which the map is unknown and no known thing stands, each as a box in W [m], largest first.
/// `known_W` are the extents of what is known. @pre plane_W is in W, which is z up.
std::vector<Eigen::AlignedBox3d> HiddenRegions(const world::VoxelSpace& space,
                                               const world::SupportPlane& plane_W,
                                               const std::vector<Eigen::AlignedBox3d>& known_W,
                                               const HiddenSpaceConfig& config);

}  // namespace secondlook::planning
