#pragma once

#include <vector>

#include "lib/geometry/mesh.h"

namespace secondlook::geometry {

/// The borders of an open mesh: each a chain of vertices along edges that belong to one triangle
/// alone, in the direction in which the triangles have them, so that the surface is on the left
/// seen from its front. The last vertex of a loop is followed by its first. Where loops touch in a
/// vertex it is not said which goes on where.
std::vector<std::vector<int>> BorderLoops(const Mesh& mesh);

}  // namespace secondlook::geometry
