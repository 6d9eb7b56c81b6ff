#pragma once

#include "lib/common/pose.h"
#include "lib/perception/symmetry.h"

namespace secondlook::perception {

/// Of the poses that the symmetry makes the same as X_CB, the one turned the least from X_CA. Only
/// motions that keep the colour count when `color` is true.
Pose NearestEquivalent(const Pose& X_CA, const Pose& X_CB, const Symmetry& symmetry, bool color);

}  // namespace secondlook::perception
