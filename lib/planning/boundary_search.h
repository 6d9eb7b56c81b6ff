#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/world/brick_grid.h"
#include "lib/world/leap_field.h"
#include "lib/world/support_plane.h"
#include "lib/world/surface_volume.h"

namespace secondlook::planning {

struct BoundarySearchConfig {
  double spacing_m{0.015};       ///< Between the places of a border that are asked.
  double patch_radius_m{0.02};   ///< Of the surface beside a border that tells its trend.
  double reach_m{0.02};          ///< So far beyond the border the surface is estimated.
  double footing_m{0.006};       ///< A border lower than this above the support is where it stands.
  double distance_m{0.55};       ///< From the sensor to the surface, where it measures best.
  double max_incidence_deg{60};  ///< Views of the estimated surface that are flatter are none.
  double clearance_m{0.08};      ///< Of the sensor from the support and whatever is known.
  double max_occlusion{0.5};     ///< Views of which a larger share is blocked are none.
  int most{100};                 ///< Candidates; of more they are taken evenly along the borders.

  template <class A>
  void Serialize(A* a) {
    a->Visit("spacing_m", &spacing_m);
    a->Visit("patch_radius_m", &patch_radius_m);
    a->Visit("reach_m", &reach_m);
    a->Visit("footing_m", &footing_m);
    a->Visit("distance_m", &distance_m);
    a->Visit("max_incidence_deg", &max_incidence_deg);
    a->Visit("clearance_m", &clearance_m);
    a->Visit("max_occlusion", &max_occlusion);
    a->Visit("most", &most);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// How a surface probably goes on beyond its border.
struct SurfaceTrend {
  Eigen::Vector3d p_W;       ///< A point of the estimated surface [m].
  Eigen::Vector3d normal_W;  ///< Of it, unit, outward.
  double border{};           ///< Length of the border loop it lies at [m].
};

/// The trends of a partial surface beyond its borders (Boundary Search; Kriegel et al. 2011):
/// beside the border a quadratic patch is fitted, and followed across the border with its
/// curvature. Places where it stands on the support are left out.
/// @throws ConfigError when `config` is not valid.
std::vector<SurfaceTrend> FindTrends(const world::PartialMesh& surface,
                                     const world::SupportPlane& plane_W,
                                     const BoundarySearchConfig& config = {});

/// Where the surface probably goes on far from its borders: points of what fills its holes flatly
/// (perception::FillHoles), a `spacing_m` apart. Beside an edge of the thing the trends of its
/// border lead into free space; these lead to its other side.
/// @throws ConfigError when `config` is not valid.
std::vector<SurfaceTrend> TrendsAcrossHoles(const world::PartialMesh& surface,
                                            const world::SupportPlane& plane_W,
                                            const BoundarySearchConfig& config = {});

/// A pose from which a trend would be measured well.
struct ScanCandidate {
  Pose X_WC{Pose::Identity()};  ///< Looks at the trend's point.
  int trend{};                  ///< Index.
  double occlusion{};           ///< Share of the view of it that something known blocks.
};

/// For each trend the pose that sees it with the least occlusion, then most upright, of those on
/// the sphere of the sensor's best distance around it that the incidence allows and that stand
/// clear of what the map knows (Kriegel 2013, III-B; Prieto et al. 2003). None for trends that no
/// pose sees.
/// @param leaps Of `grid`, refreshed.
/// @throws ConfigError when `config` is not valid.
std::vector<ScanCandidate> CandidateScans(const std::vector<SurfaceTrend>& trends,
                                          const world::BrickGrid& grid,
                                          const world::LeapField& leaps,
                                          const world::SupportPlane& plane_W,
                                          const BoundarySearchConfig& config = {});

}  // namespace secondlook::planning
