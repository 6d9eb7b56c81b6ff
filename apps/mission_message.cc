#include "apps/mission_message.h"

#include <utility>

#include "apps/to_message.h"
#include "lib/common/version.h"

namespace secondlook::apps {

second_look::mission_t DescribeStart(const RunConfig& config, const world::ObjectDatabase& database,
                                     Time now) {
  second_look::mission_t mission{};
  mission.utime = ToUtime(now);
  mission.version = kVersion;
  mission.seed = static_cast<std::int64_t>(config.seed);
  mission.config = ToText(config);
  mission.task = ToMessage(config.task);
  mission.task.utime = mission.utime;
  for (const world::ObjectModel& model : database.models()) mission.models.push_back(model.name);
  mission.num_models = static_cast<std::int32_t>(mission.models.size());
  mission.progress = 0;
  mission.compute_seconds = 0.0;
  mission.motion_seconds = 0.0;
  mission.total_seconds = 0.0;
  mission.metres = 0.0;
  mission.num_modelled = 0;
  return mission;
}

second_look::mission_t DescribeEnd(second_look::mission_t mission, const MissionRecord& record,
                                   Progress progress, Time now) {
  mission.utime = ToUtime(now);
  mission.end = record.end;
  mission.progress = static_cast<std::int8_t>(progress);
  mission.compute_seconds = record.compute_seconds;
  mission.motion_seconds = record.motion_seconds;
  mission.total_seconds = record.total_seconds;
  mission.metres = record.metres;
  for (const ModelledThing& thing : record.modelled) {
    second_look::modelled_t modelled{};
    modelled.object_id = thing.object;
    modelled.model = thing.model;
    modelled.coverage = thing.coverage;
    modelled.num_scans = static_cast<std::int32_t>(thing.coverage.size());
    modelled.reason = thing.reason;
    mission.modelled.push_back(std::move(modelled));
  }
  mission.num_modelled = static_cast<std::int32_t>(mission.modelled.size());
  return mission;
}

}  // namespace secondlook::apps
