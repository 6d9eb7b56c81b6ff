#pragma once

#include <array>
#include <vector>

#include "lib/perception/view.h"
#include "lib/world/observation.h"
#include "lib/world/support_plane.h"

namespace secondlook::perception {

/// A cluster's pixels in two: row-major indices, ascending, neither empty.
using Cut = std::array<std::vector<int>, 2>;

/// Where `cluster`, should it be two things or three in a row that geometry does not tell apart,
/// may be cut: half way along the longest of its three sides, on the support plane or up from it;
/// across either where it is nearly square on the plane, and a third from one end where it is long.
/// Only coarse: the cut needs to leave each thing most of its part. No part has less than a sixth
/// of the pixels.
std::vector<Cut> CutsByShape(const world::Cluster& cluster, const world::SupportPlane& plane_C);

/// Where a straight edge of colour crosses the whole of `cluster`, as it does between two things
/// that stand flush beside each other or on one another: cuts by planes as those of CutsByShape(),
/// wherever nearly all along the plane the colours on its two sides differ much. What is printed on
/// one thing may do that, too, so a cut is only a question. The strongest of each direction; none
/// without colour.
std::vector<Cut> CutsByColor(const world::Cluster& cluster, const View& view);

}  // namespace secondlook::perception
