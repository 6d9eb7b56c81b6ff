#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/common/rng.h"
#include "lib/geometry/mesh.h"

namespace secondlook::geometry {

/// A point of a surface with its unit normal, in the frame its holder says [m].
struct OrientedPoint {
  Eigen::Vector3f point;
  Eigen::Vector3f normal;
};

/// A point drawn from a mesh, in M.
struct MeshSample {
  OrientedPoint surface;    ///< Normal: of the triangle, outward by its winding.
  int triangle{};           ///< Index of the triangle it lies on.
  Eigen::Vector3f weights;  ///< Barycentric on that triangle.
};

/// `count` points spread evenly by area: the surface is cut into `count` parts of one area, in the
/// order of the triangles, and a random point is drawn from each (stratified sampling).
/// @pre the mesh has area and count > 0.
std::vector<MeshSample> SampleSurface(const Mesh& mesh, int count, Rng* rng);

/// Indices of a subset of `points`, ascending, such that each cell of a grid of `spacing` > 0 [m]
/// keeps one point for each distinct direction of its normals: a point joins a kept one of its cell
/// whose normal is within `angle` [rad] (Vidal et al. 2018, A Method for 6D Pose Estimation of
/// Free-Form Rigid Objects Using Point Pair Features on Range Data, 3.1). The point kept is the
/// first of its group.
std::vector<int> SubsampleByNormals(const std::vector<OrientedPoint>& points, double spacing,
                                    double angle);

/// `points` and `more` [m], in this order, with the first point kept of each cell of a grid of
/// `spacing` > 0 [m].
std::vector<Eigen::Vector3d> Thinned(std::vector<Eigen::Vector3d> points,
                                     const std::vector<Eigen::Vector3d>& more, double spacing);

}  // namespace secondlook::geometry
