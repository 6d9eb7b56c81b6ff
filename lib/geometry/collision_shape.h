#pragma once

#include <memory>

#include <fcl/geometry/collision_geometry.h>

#include "lib/geometry/mesh.h"
#include "lib/geometry/shape.h"

namespace secondlook::geometry {

/// The shape as FCL has it, grown by `margin` >= 0 [m] on all sides (a box stays one, with its
/// edges longer by twice the margin).
std::shared_ptr<fcl::CollisionGeometryd> MakeCollisionShape(const Shape& shape, double margin);

/// The surface of the mesh as FCL has it: what lies wholly within it does not touch it.
/// @pre !mesh.empty().
std::shared_ptr<fcl::CollisionGeometryd> MakeCollisionSurface(const Mesh& mesh);

}  // namespace secondlook::geometry
