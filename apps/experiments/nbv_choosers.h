#pragma once

#include <array>
#include <string>
#include <vector>

#include "apps/experiments/nbv_decisions.h"
#include "lib/planning/tile_vote.h"

namespace secondlook::apps::nbv {

struct NamedChooser {
  std::string name;
  Chooser choose;
};

/// The side that a vote ranks first, or `rank` places after it; any, when there are not so many
/// that are not refused.
Choice Vote(const std::array<planning::ScoredTile, kSideCount>& sides,
            const std::vector<planning::Voter>& voters, planning::VoteRule rule, bool refuse,
            std::size_t rank = 0);

/// All ways to choose the second view that are compared: at random, each side, each criterion, the
/// paper's vote (Hoseini 2021, Section 4), ours, learned from the other blocks (when there are at
/// least two), and the oracle. @param decisions Must outlive them.
std::vector<NamedChooser> Choosers(const Decisions& decisions);

}  // namespace secondlook::apps::nbv
