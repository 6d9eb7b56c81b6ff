#pragma once

#include <cstdint>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "apps/experiments/experiment.h"
#include "apps/experiments/judge.h"
#include "lib/world/object_database.h"
#include "sim/scene.h"

namespace secondlook::apps {

/// How a mission has ended, e.g. "settled".
const char* ToString(Progress progress);

/// One of the `verdicts` of docs/cli.md.
nlohmann::ordered_json ToJson(const Verdict& verdict);

/// Runs one mission of the default robot in `scene`, all its errors drawn from `seed`, and judges
/// it: the `details` of docs/cli.md. With a `report` folder, leaves its scene and result there.
nlohmann::ordered_json RunMissionTrial(const sim::Scene& scene, const ExperimentOptions& options,
                                       const world::ObjectDatabase& database, std::uint64_t seed,
                                       const std::filesystem::path& report);

}  // namespace secondlook::apps
