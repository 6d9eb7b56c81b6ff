#pragma once

#include <optional>
#include <vector>

#include "lib/world/object_belief.h"
#include "lib/world/observation.h"
#include "lib/world/support_plane.h"

namespace secondlook::world {

/// All that is known of the scene: the views taken, the support plane, and the things on it.
struct SceneBelief {
  std::optional<SupportPlane> plane_W;
  std::vector<SupportPlane> further_W;  ///< Others that things may stand on: shelves, box tops.
  std::vector<Observation> views;       ///< In the order they were taken.
  std::vector<ObjectBelief> objects;    ///< By id.
};

}  // namespace secondlook::world
