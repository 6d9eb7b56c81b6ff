#pragma once

#include "apps/mission.h"
#include "apps/run_config.h"
#include "lib/world/object_database.h"

#include "second_look/mission_t.hpp"

namespace secondlook::apps {

/// The message that a mission begins now.
second_look::mission_t DescribeStart(const RunConfig& config, const world::ObjectDatabase& database,
                                     Time now);

/// The same mission, ended; the costs are those of `record`.
second_look::mission_t DescribeEnd(second_look::mission_t mission, const MissionRecord& record,
                                   Progress progress, Time now);

}  // namespace secondlook::apps
