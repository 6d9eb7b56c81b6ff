#pragma once

namespace secondlook::apps {

/// The version of this program, as CHANGELOG.md counts it.
const char* Version();

}  // namespace secondlook::apps
