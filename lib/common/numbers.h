#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace secondlook {

/// The finite number that `text` is as a whole, written with a point whatever the locale; empty
/// when it is none. A leading '+' and spaces around it are no part of a number.
std::optional<double> ParseNumber(std::string_view text);

/// The numbers of a list such as "0,-1,0.5"; empty when one of them is none.
std::optional<std::vector<double>> ParseNumbers(std::string_view text);

}  // namespace secondlook
