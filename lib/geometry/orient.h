#pragma once

#include "lib/geometry/mesh.h"

namespace secondlook::geometry {

/// Turns over the triangles of `mesh` that wind the wrong way: those whose back sees more of the
/// outside than their front, by rays cast to both sides. A sheet seen alike from both sides is left
/// as it is. Meshes come inside out, and with some faces turned; what asks which way a surface
/// faces needs it right. A mesh of which fewer than 2 % are wrong is left as it is. Returns how
/// many were turned over. @throws InvalidArgument without a triangle.
int OrientOutward(Mesh* mesh);

}  // namespace secondlook::geometry
