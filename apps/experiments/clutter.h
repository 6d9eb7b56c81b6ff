#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lib/perception/view.h"
#include "lib/world/observation.h"
#include "sim/scene.h"

namespace secondlook::apps {

/// One thing among others on a table, as a single frame shows it.
struct ClutteredThing {
  std::string name;
  Pose X_CM{Pose::Identity()};  ///< The truth.
  double visible{};             ///< The share of its silhouette that is seen.
  perception::View view;        ///< With `cluster` as its only cluster.
  world::Cluster cluster;       ///< That shows most of it; no pixels: segmentation found none.
};

/// Crowds a table with `things` (DrawCrowdedTable) and looks at one of them from 0.6 to 1.2 m, 20
/// to 70 degrees above the table, with the design's errors; from a side from which more than half
/// of it is seen. Depends on the arguments alone.
ClutteredThing DrawClutteredThing(const std::vector<sim::SceneObject>& things, std::uint64_t seed);

}  // namespace secondlook::apps
