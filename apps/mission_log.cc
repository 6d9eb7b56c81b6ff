#include "apps/mission_log.h"

#include <utility>

#include "apps/to_message.h"
#include "lib/common/error.h"
#include "lib/common/version.h"
#include "lib/hal/replay/description.h"

namespace secondlook::apps {
namespace {

/// The size of a part [bytes].
std::int64_t PartBytes(double part_mb) {
  if (!(part_mb >= 1.0 && part_mb <= 1e6)) {
    Throw<ConfigError>("--log-split-mb {}: must be 1 to 1000000", part_mb);
  }
  return static_cast<std::int64_t>(part_mb * 1e6);
}

}  // namespace

MissionLog::MissionLog(const std::filesystem::path& file, double part_mb)
    : file_(file), log_(file, PartBytes(part_mb)) {}

void MissionLog::Begin(const RunConfig& config, const world::ObjectDatabase& database,
                       bool plan_only, ReadyRobot* ready) {
  second_look::rec_mission_t mission{};
  mission.version = kVersion;
  mission.config = ToText(WithAbsolutePaths(config));
  mission.plan_only = plan_only ? 1 : 0;
  mission.models = ModelsOf(database);
  mission.num_models = static_cast<std::int32_t>(mission.models.size());
  hal::Describe(ready->robot, ready->calibration, ready->hand, &mission);
  recorder_.Begin(std::move(mission));
  ready->robot = hal::Tap(std::move(ready->robot), &recorder_);
}

StopRequest MissionLog::Recorded(StopRequest stop, std::function<int()> signal) {
  return [this, stop = std::move(stop), signal = std::move(signal)] {
    const bool stopped = stop();
    recorder_.StopAsked(stopped, signal());
    return stopped;
  };
}

void MissionLog::Task(const world::Task& task) { recorder_.Task(ToMessage(task)); }

void MissionLog::NewModel(const world::ObjectModel& model) {
  recorder_.NewModel(ToRecorded(model));
}

std::string MissionLog::Close() {
  log_.Close();
  const std::string failure = log_.failure();
  if (failure.empty()) return fmt::format("the recording lies in {}", file_.string());
  return fmt::format("the recording in {} is not whole: {}", file_.string(), failure);
}

second_look::rec_model_t ToRecorded(const world::ObjectModel& model) {
  second_look::rec_model_t recorded{};
  recorded.name = model.name;
  recorded.hash = static_cast<std::int64_t>(model.hash);
  return recorded;
}

std::vector<second_look::rec_model_t> ModelsOf(const world::ObjectDatabase& database) {
  std::vector<second_look::rec_model_t> models;
  for (const world::ObjectModel& model : database.models()) {
    models.push_back(ToRecorded(model));
  }
  return models;
}

}  // namespace secondlook::apps
