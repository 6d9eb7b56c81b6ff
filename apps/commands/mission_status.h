#pragma once

#include "apps/commands/commands.h"
#include "apps/mission.h"

namespace secondlook::apps {

/// The exit status of a mission that has ended with `progress`; `stop_signal` is the signal that
/// has stopped it, or 0 when a command did.
inline int StatusOf(Progress progress, int stop_signal) {
  if (progress == Progress::kSettled) return kDone;
  const bool by_signal = progress == Progress::kStopped && stop_signal != 0;
  return by_signal ? 128 + stop_signal : kUnsettled;
}

}  // namespace secondlook::apps
