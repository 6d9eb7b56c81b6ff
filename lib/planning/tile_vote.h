#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lib/planning/tile_scores.h"

namespace secondlook::planning {

enum class VoteRule {
  kPlurality,  ///< A vote for the tile that a criterion scores most (Hoseini 2021, 4.2).
  kBorda,      ///< A point for every tile that a criterion scores less.
};

/// A criterion and how much its vote counts.
struct Voter {
  Criterion criterion{};
  double weight{1.0};
};

/// The paper's four: V, L, P and S, one vote each.
std::vector<Voter> PaperVoters();

struct RankedTile {
  Tile tile{};
  double votes{};
  double borda{};  ///< What breaks ties of votes.
};

/// Where to look from for the next view of one object, from a single view of it.
struct TileRanking {
  std::vector<RankedTile> tiles;  ///< Those that are candidates, best first.
  std::string reason;             ///< Why there are none; "" when there are.

  /// The best tile that can be reached; none when no tile can.
  std::optional<Tile> Best(const std::function<bool(Tile)>& reachable) const;
};

/// Holds the poll over the tiles that are not refused. A criterion that scores NaN for every tile
/// abstains; one that scores NaN for some ranks those last and does not vote for them. A vote for
/// several tiles that score alike goes to the first of them in the order of Tile. Tiles with as
/// many votes are ordered by their Borda points, then by their order in Tile.
/// @throws InvalidArgument without voters or for a weight that is not positive.
TileRanking RankTiles(const std::vector<ScoredTile>& tiles, const std::vector<Voter>& voters,
                      VoteRule rule = VoteRule::kPlurality);

}  // namespace secondlook::planning
