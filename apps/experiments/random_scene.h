#pragma once

#include <string>
#include <vector>

#include "lib/common/pose.h"
#include "lib/common/rng.h"
#include "sim/scene.h"

namespace secondlook::apps {

/// Meshes that random scenes draw from.
struct Repertoire {
  std::vector<sim::SceneObject> known;    ///< Of the object database.
  std::vector<sim::SceneObject> unknown;  ///< Of no database.
};

/// The objects in the model folder `models` as known, those in `unfamiliar` (may be "") as unknown.
/// @throws ConfigError as ObjectDatabase::Load does.
Repertoire LoadRepertoire(const std::string& models, const std::string& unfamiliar);

/// A table with five to eight things, drawn without repetition, of which none to two are unknown
/// (less often than not), at random places at least 3 cm apart and turned at random; up to two
/// crates on the floor; the robot starts 1.5 to 2.2 m from the table's centre on any side, facing
/// it within 15 degrees. Depends on `rng` alone.
sim::Scene DrawScene(const Repertoire& repertoire, Rng* rng);

/// Puts the robot's start 1.5 to 2.2 m from the table's centre on any side, facing it within 15
/// degrees.
void PlaceRobot(sim::Scene* scene, Rng* rng);

/// Puts a crate of random size on the floor, 1.1 to 2.2 m from the table's centre; none where the
/// robot has its start.
void AddCrate(const std::string& name, sim::Scene* scene, Rng* rng);

/// A small table, crowded with `things` at random places at least 3 cm apart and turned at random:
/// from most sides, some hide others. What finds no room in many attempts is left out.
sim::Scene DrawCrowdedTable(const std::vector<sim::SceneObject>& things, Rng* rng);

/// A camera that looks at `target_W` from 0.6 to 1.2 m, 20 to 70 degrees above it, from any side.
Pose DrawViewOf(const Eigen::Vector3d& target_W, Rng* rng);

/// … at a point near the middle of the table.
Pose DrawView(const sim::Table& table, Rng* rng);

/// Takes `count` random objects out of `pool`, or all when there are fewer.
std::vector<sim::SceneObject> DrawObjects(std::vector<sim::SceneObject> pool, int count, Rng* rng);

}  // namespace secondlook::apps
