#include "apps/model_watch.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "lib/common/error.h"

namespace secondlook::apps {

ModelWatch::ModelWatch(std::filesystem::path folder, const world::ObjectDatabase& known)
    : folder_(std::move(folder)) {
  for (const world::ObjectModel& model : known.models()) seen_.insert(model.name);
}

std::vector<world::ObjectModel> ModelWatch::Take() {
  std::vector<world::ObjectModel> models;
  if (!std::filesystem::is_directory(folder_)) return models;
  for (const std::filesystem::path& folder : world::ModelFolders(folder_)) {
    if (!seen_.insert(folder.filename().string()).second) continue;
    try {
      world::ObjectModel model = world::ReadModel(folder);
      const bool by_its_folder = model.name == folder.filename().string();
      if (by_its_folder || seen_.insert(model.name).second) models.push_back(std::move(model));
    } catch (const ConfigError& error) {
      spdlog::warn("a new model is left out: {}", error.what());
    }
  }
  return models;
}

}  // namespace secondlook::apps
