#pragma once

#include <cstdint>

#include <nlohmann/json.hpp>

#include "apps/mission.h"

namespace secondlook::apps {

/// What a mission found and did, with the keys of docs/cli.md (`run`, mission.json). Depends on the
/// mission alone: no wall time is in it.
nlohmann::ordered_json ToJson(const world::SceneBelief& belief, const MissionRecord& record,
                              std::uint64_t seed);

}  // namespace secondlook::apps
