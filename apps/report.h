#pragma once

#include <filesystem>

#include "apps/mission.h"
#include "apps/run_config.h"
#include "apps/story.h"

namespace secondlook::apps {

/// Writes what a mission leaves behind into `folder`: report.html, which shows `story`,
/// mission.json, the effective config.yaml, and a picture of each view, view_<i>.png.
/// @throws ConfigError when that cannot be written.
void WriteReport(const RunConfig& config, const Mission& mission, const Story& story,
                 const std::filesystem::path& folder);

/// Prints a table of the objects and the costs of the mission to standard output.
void PrintSummary(const Mission& mission, double processor_seconds);

}  // namespace secondlook::apps
