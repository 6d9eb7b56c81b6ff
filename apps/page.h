#pragma once

#include <string>

#include "apps/story.h"

namespace secondlook::apps {

/// The page that explains a mission: one HTML file that fetches nothing.
std::string Page(const StoryPart& story);

/// The same page without messages: it goes on asking where it came from for them
/// (monitor_server.h).
std::string LivePage();

}  // namespace secondlook::apps
