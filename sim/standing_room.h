#pragma once

#include <vector>

#include "sim/scene.h"

namespace secondlook::sim {

/// @throws ConfigError naming the first thing in `scene`, with its `objects`, that the robot or a
/// moving obstacle would stand in where it starts, or when the robot would stand off the floor.
void RequireStandingRoom(const Scene& scene, const std::vector<PlacedObject>& objects);

}  // namespace secondlook::sim
