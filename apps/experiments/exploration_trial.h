#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "apps/experiments/experiment.h"
#include "lib/world/object_database.h"
#include "sim/scene.h"

namespace secondlook::apps {

/// A table with known and unknown things, three of each, and what the robot knows at the beginning.
struct HalfKnownTable {
  sim::Scene scene;
  world::ObjectDatabase database;  ///< The three known ones.
};

/// Draws one: of the household by an even `trial`, of a workshop by an odd one. What the model
/// folders do not have enough of the one kind is taken of the other.
/// @throws ConfigError as LoadRepertoire() does.
HalfKnownTable DrawHalfKnownTable(const ExperimentOptions& options, int trial);

/// A model that an exploration has made, and what it truly is.
struct MadeModel {
  std::string truth;  ///< Name of the thing that was modelled; "" when there is none.
  world::ObjectModel model;
};

/// What an exploration has come to.
struct Explored {
  nlohmann::ordered_json result;  ///< Its end, looks, costs, collisions, verdicts, and attempts.
  std::vector<MadeModel> models;
};

/// A mission that models what it does not know, scans chosen by `strategy`
/// (ModellingConfig::strategy).
Explored Explore(const HalfKnownTable& table, const std::string& strategy, std::uint64_t seed);

}  // namespace secondlook::apps
