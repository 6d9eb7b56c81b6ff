#pragma once

#include <string_view>
#include <vector>

namespace secondlook::transport {

/// The text of every file in messages/, as this program was built with.
const std::vector<std::string_view>& MessageText();

}  // namespace secondlook::transport
