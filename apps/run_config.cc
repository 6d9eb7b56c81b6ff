#include "apps/run_config.h"

#include "lib/common/yaml_reader.h"

namespace secondlook::apps {
namespace {

namespace fs = std::filesystem;

/// Makes the relative paths in `config` relative to the working folder instead of `folder`.
void ResolvePaths(const fs::path& folder, RunConfig* config) {
  const auto resolve = [&](std::string* path) {
    if (path->empty() || fs::path(*path).is_absolute()) return;
    *path = (folder / *path).lexically_normal().string();
  };
  resolve(&config->models);
  if (auto* sim = std::get_if<sim::SimConfig>(&config->robot)) resolve(&sim->scene);
}

}  // namespace

RunConfig LoadRunConfig(const fs::path& file, const std::vector<std::string>& overrides) {
  RunConfig config;
  std::get<sim::SimConfig>(config.robot).scene.clear();
  ApplyLayer(ReadYamlFile(file), &config);
  ResolvePaths(file.parent_path(), &config);
  for (const std::string& key_value : overrides) ApplyLayer(ParseOverride(key_value), &config);
  if (config.models.empty()) {
    Throw<ConfigError>(
        "{}: 'models' is missing: the folder of the object database, as "
        "`secondlook model add` makes it",
        file.string());
  }
  const auto* sim = std::get_if<sim::SimConfig>(&config.robot);
  if (sim != nullptr && sim->scene.empty()) {
    Throw<ConfigError>("{}: 'robot.scene' is missing: the scene file to simulate", file.string());
  }
  return config;
}

void RequireKnownClasses(const world::Task& task, const world::ObjectDatabase& database) {
  for (const auto& [name, confidence] : task.wanted) {
    if (database.Find(name) != nullptr) continue;
    std::string known;
    for (const world::ObjectModel& model : database.models()) {
      known += (known.empty() ? "" : ", ") + model.name;
    }
    Throw<ConfigError>("task.wanted names '{}', which is not in the object database; it holds {}",
                       name, known);
  }
}

}  // namespace secondlook::apps
