#pragma once

#include <string_view>

namespace secondlook::apps {

/// page/ as this program was built with: page.html with the style and the script in it, and
/// "{{story}}" where the messages go.
std::string_view PageText();

}  // namespace secondlook::apps
