#pragma once

#include <spdlog/spdlog.h>

namespace secondlook {

/// Routes the log to standard error, as `HH:MM:SS.mmm level message`. Libraries log state changes
/// once and never what they throw; nothing but apps/ prints.
void StartLog(spdlog::level::level_enum level);

}  // namespace secondlook
