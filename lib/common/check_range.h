#pragma once

#include <string_view>

#include "lib/common/error.h"

namespace secondlook {

/// Checks a value of a configuration. @throws ConfigError naming it, the value and the bounds, when
/// it lies outside `low`..`high` or is not a number.
inline void CheckRange(double value, double low, double high, std::string_view name) {
  if (!(value >= low && value <= high)) {
    Throw<ConfigError>("{} = {} must lie in {}..{}", name, value, low, high);
  }
}

}  // namespace secondlook
