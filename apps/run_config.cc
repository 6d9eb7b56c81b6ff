#include "apps/run_config.h"

#include "lib/common/files.h"
#include "lib/common/yaml_reader.h"

namespace secondlook::apps {
namespace {

namespace fs = std::filesystem;

/// Every path in `config` that is relative.
std::vector<std::string*> RelativePaths(RunConfig* config) {
  std::vector<std::string*> paths{&config->models, &config->learned, &config->classifier};
  if (auto* sim = std::get_if<sim::SimConfig>(&config->robot)) {
    paths.push_back(&sim->scene);
    paths.push_back(&sim->calibration);
    if (sim->arm) paths.push_back(&sim->arm->urdf);
  }
  if (auto* real = std::get_if<RealConfig>(&config->robot)) {
    paths.push_back(&real->calibration);
    if (real->arm) paths.push_back(&real->arm->urdf);
  }
  std::erase_if(paths, [](const std::string* path) {
    return path->empty() || fs::path(*path).is_absolute();
  });
  return paths;
}

}  // namespace

RunConfig LoadRunConfig(const fs::path& file, const std::vector<std::string>& overrides) {
  RunConfig config;
  std::get<sim::SimConfig>(config.robot).scene.clear();
  ApplyLayer(ReadYamlFile(file), &config);
  for (std::string* path : RelativePaths(&config)) {
    *path = (file.parent_path() / *path).lexically_normal().string();
  }
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
  const auto* real = std::get_if<RealConfig>(&config.robot);
  if (real != nullptr && real->calibration.empty()) {
    Throw<ConfigError>(
        "{}: 'robot.calibration' is missing: the calibration file, as `secondlook calibrate` makes "
        "it",
        file.string());
  }
  return config;
}

world::ObjectDatabase LoadDatabase(const RunConfig& config) {
  auto database = world::ObjectDatabase::Load(config.models);
  if (config.learned.empty() || !fs::is_directory(config.learned)) return database;
  if (fs::is_empty(config.learned)) return database;
  const auto learned = world::ObjectDatabase::Load(config.learned);
  for (const world::ObjectModel& model : learned.models()) {
    if (database.Find(model.name) != nullptr) {
      Throw<ConfigError>("'{}' is a model in both {} (models) and {} (learned): remove one",
                         model.name, config.models, config.learned);
    }
    database.Add(model);
  }
  return database;
}

RunConfig ParseRunConfig(const std::string& text, const std::string& source) {
  RunConfig config;
  ApplyLayer(ParseYaml(text, source), &config);
  return config;
}

RunConfig WithAbsolutePaths(RunConfig config) {
  for (std::string* path : RelativePaths(&config)) {
    *path = fs::absolute(*path).lexically_normal().string();
  }
  return config;
}

std::string ToText(const RunConfig& config) { return ToYaml(config); }

void SaveRunConfig(const RunConfig& config, const fs::path& file) {
  RunConfig moved = config;
  const fs::path folder = fs::absolute(file).lexically_normal().parent_path();
  for (std::string* path : RelativePaths(&moved)) {
    *path = fs::absolute(*path).lexically_normal().lexically_relative(folder).string();
  }
  WriteFile(file, ToYaml(moved));
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
