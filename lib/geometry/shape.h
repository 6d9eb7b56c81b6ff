#pragma once

#include <variant>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/mesh.h"

namespace secondlook::geometry {

/// A box about the origin of its frame S, along its axes.
struct Box {
  Eigen::Vector3d size{0.0, 0.0, 0.0};  ///< Edges [m], > 0.
};

/// A cylinder about the z axis of its frame S, half of it below the origin.
struct Cylinder {
  double radius{};  ///< [m], > 0.
  double height{};  ///< [m], > 0.
};

/// A ball about the origin of its frame S.
struct Sphere {
  double radius{};  ///< [m], > 0.
};

/// One of the solids that bodies of robots are made of.
using Shape = std::variant<Box, Cylinder, Sphere>;

/// A solid at a place.
struct PlacedShape {
  Shape shape;
  Pose X_AS{Pose::Identity()};  ///< In the frame that whoever holds it says.
};

/// From the point Q to the shape [m]; 0 on it and within.
double Distance(const Shape& shape, const Eigen::Vector3d& p_SQ);

/// The radius of the smallest ball about the origin of S that holds the shape [m].
double BoundingRadius(const Shape& shape);

/// Its surface, in S, in one colour; round ones with `segments` >= 6 around.
Mesh MakeMesh(const Shape& shape, int segments, const Eigen::Vector3f& color);

}  // namespace secondlook::geometry
