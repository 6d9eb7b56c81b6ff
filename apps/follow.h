#pragma once

#include "apps/decision_check.h"
#include "apps/mission.h"
#include "lib/hal/replay/recording.h"

namespace secondlook::apps {

/// Keeps a mission on the looks of a recorded one: a choice of its own that differs is told to
/// `check` and replaced. Both must outlive what is returned.
LookChooser FollowLooks(const hal::Recording& recording, DecisionCheck* check);

}  // namespace secondlook::apps
