#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "lib/hal/base.h"
#include "lib/planning/cost_map.h"
#include "lib/world/support_plane.h"
#include "lib/world/voxel_space.h"

namespace secondlook::planning {

/// What the base would touch, and where.
struct Contact {
  bool support{};        ///< A support surface; false: an occupied voxel.
  Eigen::Vector3d p_WQ;  ///< About where [m].
};

/// Tests whether the base would touch anything if it stood somewhere (FCL): an upright cylinder of
/// SafeRadius() from min_height_m to the base's height against the occupied voxels and against the
/// solid below every support surface, grown by support_margin_m. Threading: Touches() from any
/// number of threads.
class CollisionChecker {
 public:
  /// @param space Its surroundings as they are now.
  /// @throws ConfigError when `config` is not valid.
  CollisionChecker(const world::VoxelSpace& space,
                   const std::vector<world::SupportPlane>& supports_W, const hal::BaseInfo& base,
                   const CostMapConfig& config = {});
  ~CollisionChecker();
  CollisionChecker(CollisionChecker&&) noexcept;
  CollisionChecker& operator=(CollisionChecker&&) noexcept;

  /// What the base touches at `X_WB`; empty when it is free.
  /// @throws InvalidArgument for a pose that is not finite.
  std::optional<Contact> Touches(const Pose2& X_WB) const;

 private:
  struct Shapes;
  std::unique_ptr<Shapes> shapes_;
};

}  // namespace secondlook::planning
