#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/geometry/shape.h"
#include "lib/world/support_plane.h"
#include "lib/world/voxel_space.h"

namespace secondlook::planning {

/// What an arm must not touch, and why.
enum class ObstacleKind { kOccupied, kUnknown, kSupport, kFloor, kWorkspaceEdge };

/// "occupied space", "unknown space", "a support surface", "the floor" or "the edge of
/// safety.limits.arm_workspace".
std::string ToString(ObstacleKind kind);

struct Obstacle {
  ObstacleKind kind{};
  geometry::PlacedShape solid;  ///< A box, in W.
};

struct ObstacleConfig {
  bool avoid_unknown{true};       ///< What was never seen counts as occupied.
  double own_space_m{0.1};        ///< As near as this to its own body nothing is unknown to it.
  double support_margin_m{0.02};  ///< Support surfaces are grown by so much.

  template <class A>
  void Serialize(A* a) {
    a->Visit("avoid_unknown", &avoid_unknown);
    a->Visit("own_space_m", &own_space_m);
    a->Visit("support_margin_m", &support_margin_m);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// Everything within `reach` [m] of `p_WR`: the occupied voxels, the unknown ones (also where the
/// map does not reach), all below support surfaces, and the floor at z = 0. Voxels are put together
/// to boxes. Unknown voxels as near as own_space_m to the `own_body_W` of the robot as it stands
/// are none: it is there itself.
/// @throws ConfigError when `config` is not valid, InvalidArgument for a place or reach that is not
/// finite.
std::vector<Obstacle> ObstaclesAround(const Eigen::Vector3d& p_WR, double reach,
                                      const world::VoxelSpace& space,
                                      const std::vector<world::SupportPlane>& supports_W,
                                      const std::vector<geometry::PlacedShape>& own_body_W,
                                      const ObstacleConfig& config = {});

/// Six walls around the box `box_A` of a frame A at X_WA, so thick that no arm reaches beyond.
std::vector<Obstacle> WallsAround(const Eigen::AlignedBox3d& box_A, const Pose& X_WA);

}  // namespace secondlook::planning
