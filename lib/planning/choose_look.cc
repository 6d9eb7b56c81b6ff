#include "lib/planning/choose_look.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace secondlook::planning {
namespace {

/// What a look is expected to bring, for people.
std::string Explain(const world::Look& look) {
  const std::string way =
      look.way == world::LookWay::kArm
          ? fmt::format("{:.1f} s by the arm", look.seconds)
          : fmt::format("{:.1f} s and {:.2f} m to drive", look.seconds, look.metres);
  const char* what = look.kind == "scan" ? "adds {:.0f} % to the surface that is seen"
                                         : "sees {:.0f} % of the rays to the box";
  return fmt::format("{}; gain {:.3g}; {}; score {:.3g}",
                     fmt::format(fmt::runtime(what), 100.0 * look.visibility), look.gain, way,
                     look.score);
}

}  // namespace

std::string RefusalSummary(const std::vector<world::Look>& looks) {
  std::vector<std::pair<std::string, int>> reasons;
  int refused = 0;
  for (const world::Look& look : looks) {
    if (look.feasible) continue;
    ++refused;
    std::string name = "not checked";
    for (const world::LookCheck& check : look.checks) {
      if (!check.passed) name = check.name;
    }
    const auto found = std::find_if(reasons.begin(), reasons.end(),
                                    [&](const auto& entry) { return entry.first == name; });
    if (found == reasons.end()) {
      reasons.emplace_back(name, 1);
    } else {
      ++found->second;
    }
  }
  if (refused == 0) return fmt::format("none of {} refused", looks.size());
  std::stable_sort(reasons.begin(), reasons.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string summary = fmt::format("{} of {} refused: ", refused, looks.size());
  for (std::size_t i = 0; i < reasons.size(); ++i) {
    summary += fmt::format("{}{} {}", i == 0 ? "" : ", ", reasons[i].second, reasons[i].first);
  }
  return summary;
}

LookChoice ChooseLook(std::vector<world::Look>* looks) {
  LookChoice choice;
  double second = 0.0;
  for (int i = 0; i < static_cast<int>(looks->size()); ++i) {
    world::Look& look = (*looks)[i];
    look.chosen = false;
    if (!look.feasible) continue;
    look.reason = Explain(look);
    if (!choice.index) {
      choice.index = i;
    } else if (look.score > (*looks)[*choice.index].score) {
      second = (*looks)[*choice.index].score;
      choice.index = i;
    } else {
      second = std::max(second, look.score);
    }
  }
  if (looks->empty()) {
    choice.reason = "there are no candidates";
  } else if (!choice.index) {
    choice.reason = RefusalSummary(*looks);
  } else {
    world::Look& best = (*looks)[*choice.index];
    best.chosen = true;
    if (second > 0.0) best.reason += fmt::format(", {:.2f} times the next", best.score / second);
    choice.reason = fmt::format("{}; {}", best.reason, RefusalSummary(*looks));
  }
  return choice;
}

}  // namespace secondlook::planning
