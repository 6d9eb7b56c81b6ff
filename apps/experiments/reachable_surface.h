#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/mesh.h"
#include "lib/geometry/sampling.h"

namespace secondlook::apps {

/// A point of an object's true surface, in W.
struct SurfacePoint {
  Eigen::Vector3d p_W;
  Eigen::Vector3d normal_W;  ///< Unit, outward by the mesh's winding.
  bool reachable{};          ///< A sensor could see it.
};

/// `count` points spread evenly over the object `mesh` at `X_WM` that stands by itself on a table
/// of height `table` [m]. Reachable are those that one at least of 2000 places sees, none of them
/// chosen by what is being measured: spread evenly over the half spheres of 0.35, 0.45 and 0.55 m
/// about the middle of the object, at least 5 cm above the table,
/// with no more than 75 degrees of incidence and nothing in between.
std::vector<SurfacePoint> ReachableSurface(const geometry::Mesh& mesh, const Pose& X_WM,
                                           double table, int count, std::uint64_t seed);

/// How a surface that was measured compares with the true one.
struct SurfaceFigures {
  double
      reachable_within_1mm{};  ///< Share of the reachable surface with something measured there …
  double all_within_1mm{};     ///< … and of the whole.
  double reachable_within_3mm{};
  double rms{};  ///< Of the distances of what was measured from the truth [m].
};

/// Compares points of the measured surface with `truth`, after the rigid motion of all together
/// that brings them nearest to it (point-to-plane ICP). All 0 for no points.
SurfaceFigures CompareSurface(const std::vector<Eigen::Vector3d>& measured_W,
                              const std::vector<SurfacePoint>& truth);

/// Points spread evenly over `mesh`, one a square of side `spacing` [m]; none for an empty one.
std::vector<Eigen::Vector3d> SpreadOver(const geometry::Mesh& mesh, double spacing,
                                        std::uint64_t seed);

}  // namespace secondlook::apps
