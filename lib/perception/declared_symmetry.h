#pragma once

#include <vector>

#include "lib/geometry/mesh.h"
#include "lib/perception/symmetry.h"
#include "lib/world/object_database.h"

namespace secondlook::perception {

/// Adds to `*symmetry`, which FindSymmetry() has found of `mesh`, what the user has declared: turns
/// about lines through the middle of its bounding box, and their products with the motions that are
/// there. They count as keeping the colour, whatever the print says: that is what a user declares
/// them for.
/// @throws InvalidArgument naming the symmetry when the turned surface lies too far from the mesh:
/// 3 % of its points farther than 0.05 of its diameter. @pre !mesh.empty().
void Declare(const std::vector<world::DeclaredSymmetry>& declared, const geometry::Mesh& mesh,
             Symmetry* symmetry);

}  // namespace secondlook::perception
