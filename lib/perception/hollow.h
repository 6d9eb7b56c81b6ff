#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/world/support_plane.h"

namespace secondlook::perception {

/// Tells which parts are the two sides of one hollow thing: of a bowl the camera sees the near
/// outside and, over its rim, the far inside, with nothing measured between. A part that bends
/// inwards, that is as high as another and reaches to it is that one's inside.
/// @param parts_C points [m, camera frame], none empty.
/// @param window the width of surface that is looked at for how it bends [m].
/// @return for each part the index of the part it belongs to: its own, or that of its outside.
std::vector<int> FindOutsides(const std::vector<std::vector<Eigen::Vector3d>>& parts_C,
                              const world::SupportPlane& plane_C, double window);

}  // namespace secondlook::perception
