#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "apps/mission_config.h"
#include "apps/real_robot.h"
#include "apps/safety_config.h"
#include "lib/common/error.h"
#include "lib/world/object_database.h"
#include "lib/world/task.h"
#include "sim/sim_robot.h"

namespace secondlook::apps {

/// The robot's backend, chosen by its tag: `robot: !Sim {scene: …}`.
using RobotConfig = std::variant<sim::SimConfig, RealConfig>;

/// The configuration of `secondlook run` and `check`.
struct RunConfig {
  RobotConfig robot;
  std::string models;      ///< Folder of the object database.
  std::string learned;     ///< Folder of the models that missions make, read beside `models`; "":
                           ///< they are not kept.
  std::string classifier;  ///< Model file of a classifier of what things look like; "": none.
  world::Task task;
  MissionConfig mission;
  SafetyConfig safety;
  std::uint64_t seed = 1;  ///< Of everything that is drawn: same seed, same mission.
  int threads = 2;         ///< At most; the mission is the same for any number.

  template <class A>
  void Serialize(A* a) {
    a->Visit("robot", &robot);
    a->Visit("models", &models);
    a->Visit("learned", &learned);
    a->Visit("classifier", &classifier);
    a->Visit("task", &task);
    a->Visit("mission", &mission);
    a->Visit("safety", &safety);
    a->Visit("seed", &seed);
    a->Visit("threads", &threads);
  }

  void Validate() const {
    if (threads < 1) Throw<ConfigError>("'threads' = {}; it must be at least 1", threads);
  }
};

/// Reads `file` over the defaults and each `KEY=VALUE` of `overrides` over that. Relative paths in
/// the file are relative to the file's folder, those in an override to the working folder.
/// @throws ConfigError with the place of what is wrong.
RunConfig LoadRunConfig(const std::filesystem::path& file,
                        const std::vector<std::string>& overrides);

/// What `config` says that the robot knows: its models and those that missions have made.
/// @throws ConfigError as ObjectDatabase::Load() does, or for two of one name.
world::ObjectDatabase LoadDatabase(const RunConfig& config);

/// Reads what ToText() has written; messages call it `source`.
/// @throws ConfigError with the place of what is wrong.
RunConfig ParseRunConfig(const std::string& text, const std::string& source);

/// The same configuration, readable from any folder.
RunConfig WithAbsolutePaths(RunConfig config);

/// `config` as YAML.
std::string ToText(const RunConfig& config);

/// Writes `config` so that LoadRunConfig reads it back, relative paths relative to the folder of
/// `file`. @throws ConfigError when that cannot be written.
void SaveRunConfig(const RunConfig& config, const std::filesystem::path& file);

/// @throws ConfigError when `task` wants a class that is not in `database`, naming those that are.
void RequireKnownClasses(const world::Task& task, const world::ObjectDatabase& database);

}  // namespace secondlook::apps
