#pragma once

#include "lib/geometry/mesh.h"

namespace secondlook::geometry {

/// `mesh` with less detail: the vertices in each cube of side `cell` [m] become one, in their
/// middle and with the mean of their colours, and triangles of which nothing is left are dropped.
/// Borders stay open. Texture coordinates become their mean, too, so that a texture is only kept
/// roughly. Deterministic. @throws InvalidArgument unless cell > 0.
Mesh ThinOut(const Mesh& mesh, double cell);

}  // namespace secondlook::geometry
