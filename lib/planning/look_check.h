#pragma once

#include <string>
#include <utility>

#include <fmt/format.h>

#include "lib/world/look.h"

namespace secondlook::planning {

/// Adds the check to `look`, whose reason it becomes when it did not pass. Returns whether it
/// passed.
inline bool AddCheck(const char* name, bool passed, std::string detail, world::Look* look) {
  if (!passed) look->reason = fmt::format("{}: {}", name, detail);
  look->checks.push_back({name, passed, std::move(detail)});
  return passed;
}

}  // namespace secondlook::planning
