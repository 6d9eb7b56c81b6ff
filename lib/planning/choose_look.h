#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lib/world/look.h"

namespace secondlook::planning {

/// Which look to take, or why none.
struct LookChoice {
  std::optional<int> index;  ///< Into the looks.
  std::string reason;        ///< In words and numbers, and what refused the others.
};

/// The feasible look of the highest score, the first of several; one whose score is not positive
/// only when no other is left. Looks of several targets may stand side by side, scored by one
/// strategy. Sets `chosen` and the `reason` of every feasible look.
LookChoice ChooseLook(std::vector<world::Look>* looks);

/// "12 of 38 refused: 9 collision, 2 path, 1 pan-tilt limits"; "none of 38 refused".
std::string RefusalSummary(const std::vector<world::Look>& looks);

}  // namespace secondlook::planning
