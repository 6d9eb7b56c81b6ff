#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/mesh.h"

namespace secondlook::sim {

/// The shadow on the floor of something that stands in the room: a convex polygon.
struct Footprint {
  std::string name;
  std::vector<Eigen::Vector2d> hull_W;  ///< Counter-clockwise, at least one point.
  Eigen::Vector2d center_W{0.0, 0.0};   ///< Of a circle around it.
  double bound{};                       ///< The radius of that circle [m].
};

/// The convex hull, counter-clockwise and without points on its edges (Andrew's monotone chain).
std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points);

/// The footprint of `mesh` at `X_WM`. @pre the mesh has a vertex.
Footprint MakeFootprint(const std::string& name, const geometry::Mesh& mesh, const Pose& X_WM);

/// Where two things are nearest to each other.
struct Nearest {
  double distance{};                  ///< 0 where they overlap [m].
  Eigen::Vector2d point_W{0.0, 0.0};  ///< On the second thing, or of it.
};

/// The nearest point of the segment from `c` to `d` to the segment from `a` to `b`.
Nearest NearestOfSegment(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                         const Eigen::Vector2d& c, const Eigen::Vector2d& d);

/// The nearest point of `footprint` to the segment from `a` to `b`, all in W.
Nearest NearestOf(const Footprint& footprint, const Eigen::Vector2d& a, const Eigen::Vector2d& b);

}  // namespace secondlook::sim
