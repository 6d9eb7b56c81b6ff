#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/world/support_plane.h"
#include "lib/world/surface_volume.h"

namespace secondlook::perception {

/// How much of a thing's surface a partial mesh has, as the mesh itself tells [m^2].
struct Coverage {
  double filled{};  ///< A_filled: the area of the triangles.
  double holes{};   ///< A_holes: of the holes, each filled by triangles to its middle.
  double unseen{};  ///< Of what could be seen: the holes without those where it stands, bulged.

  /// ĉ_m (Kriegel 2013, Eq. 6); 0 for no surface.
  double Estimated() const { return filled > 0.0 ? filled / (filled + holes) : 0.0; }
  /// The share of what the support does not hide for ever; 0 for no surface.
  double Reachable() const { return filled > 0.0 ? filled / (filled + unseen) : 0.0; }
};

/// A piece of what fills a hole of a partial surface: between an edge of its border and its middle.
struct HoleTriangle {
  Eigen::Vector3d a, b;    ///< The edge, in the border's direction [m].
  Eigen::Vector3d middle;  ///< Of the hole [m].
  double area{};           ///< [m^2].
  double bulge{1.0};       ///< The surface that it stands for, in times of `area`; 0: none to see.

  /// Unit, outward; 0 when the triangle has no area.
  Eigen::Vector3d Normal() const { return (a - b).cross(middle - b).normalized(); }
};

/// Fills the holes of `surface`. An edge of a border lower than `footing` [m] above the support is
/// where the thing stands: what lies between such edges and the middle of their hole nobody can
/// see, nor what faces the support steeply, e.g. the underside of what stands on a narrower foot.
/// Beyond other edges the surface goes on as it ended: where it turns by the angle α against
/// the flat filling, it is thought to close as a cap does, whose area is 2 / (1 + cos α) of the
/// flat one's, but not more than twice (a ball seen from one side).
/// @pre plane_W is in the frame of `surface`.
std::vector<HoleTriangle> FillHoles(const world::PartialMesh& surface,
                                    const world::SupportPlane& plane_W, double footing);

/// By FillHoles().
Coverage EstimateCoverage(const world::PartialMesh& surface, const world::SupportPlane& plane_W,
                          double footing);

/// The part of `surface` whose triangles have only vertices that are `kept`: 1, not 0, one a
/// vertex.
world::PartialMesh Part(const world::PartialMesh& surface, const std::vector<char>& kept);

/// The part of `surface` whose triangles lie wholly above `height` [m] over the support.
world::PartialMesh Above(const world::PartialMesh& surface, const world::SupportPlane& plane_W,
                         double height);

}  // namespace secondlook::perception
