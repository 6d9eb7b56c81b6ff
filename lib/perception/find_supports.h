#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/geometry/point_image.h"
#include "lib/world/support_plane.h"

namespace secondlook::perception {

struct SegmentConfig;

constexpr double kPlaneCell = 0.02;  ///< To this a plane's points are thinned, and counted [m].

/// A level plane that is large enough to stand on.
struct Support {
  world::SupportPlane plane;
  std::vector<Eigen::Vector3d> patch;  ///< The points it was fitted to.
  double height{};  ///< Of the patch, along the normal of the first that was found.
  double extent{};  ///< Of its convex extent [m2].
};

/// The level planes of a view.
struct PlaneSearch {
  std::vector<Support> supports;  ///< The one that counts first, the others by falling extent.
  std::string reason;             ///< Why there is none, with values; empty when there are some.
};

/// Finds the planes whose normal lies near `up` (unit, against gravity, in the camera frame C) and
/// that are large enough to be supports (`config`), by RANSAC, each with its own patch of points.
/// `candidates` are the indices of the measured points of `cloud` (in C) that may belong to one.
/// `floor_is_out`: no candidate is of the floor, so the largest plane counts first; else the
/// highest does, and the lowest of several, which may be the floor, is left out. Deterministic: the
/// same points give the same planes.
PlaneSearch FindSupports(const geometry::PointImage& cloud, const std::vector<int>& candidates,
                         const Eigen::Vector3d& up, const SegmentConfig& config, bool floor_is_out);

}  // namespace secondlook::perception
