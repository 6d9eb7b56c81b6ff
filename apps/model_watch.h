#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "lib/world/object_database.h"

namespace secondlook::apps {

/// Finds the models that are added to a database's folder while a mission runs. One that changes or
/// is removed meanwhile stays as it was.
class ModelWatch {
 public:
  /// `known` is what the mission knows already of the models in `folder`.
  ModelWatch(std::filesystem::path folder, const world::ObjectDatabase& known);

  /// The models that have come since the last time, by name. One that cannot be read is left out,
  /// and said once.
  std::vector<world::ObjectModel> Take();

 private:
  std::filesystem::path folder_;
  std::set<std::string> seen_;  // names of models and of their folders
};

}  // namespace secondlook::apps
