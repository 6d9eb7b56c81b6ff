#include "lib/planning/tile_vote.h"

#include <algorithm>
#include <cmath>

#include "lib/common/error.h"

namespace secondlook::planning {

std::vector<Voter> PaperVoters() {
  return {{Criterion::kVariance},
          {Criterion::kThirdMoment},
          {Criterion::kParallelism},
          {Criterion::kDissimilarity}};
}

std::optional<Tile> TileRanking::Best(const std::function<bool(Tile)>& reachable) const {
  for (const RankedTile& ranked : tiles) {
    if (reachable(ranked.tile)) return ranked.tile;
  }
  return std::nullopt;
}

TileRanking RankTiles(const std::vector<ScoredTile>& tiles, const std::vector<Voter>& voters,
                      VoteRule rule) {
  if (voters.empty()) Throw<InvalidArgument>("no criterion votes; at least one is needed");
  std::vector<ScoredTile> candidates;
  for (const ScoredTile& tile : tiles) {
    if (tile.refusal.empty()) candidates.push_back(tile);
  }
  TileRanking ranking;
  if (candidates.empty()) {
    ranking.reason = tiles.empty()
                         ? "there are no tiles"
                         : fmt::format("all {} tiles are refused; '{}' {}", tiles.size(),
                                       TileName(tiles.front().tile), tiles.front().refusal);
    return ranking;
  }
  for (const ScoredTile& tile : candidates) ranking.tiles.push_back({tile.tile, 0.0, 0.0});
  for (const Voter& voter : voters) {
    if (!(voter.weight > 0.0)) {
      Throw<InvalidArgument>("a criterion's weight is {}; it must be positive", voter.weight);
    }
    std::size_t favourite = candidates.size();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const double score = candidates[i].Of(voter.criterion);
      if (std::isnan(score)) continue;
      if (favourite == candidates.size() || score > candidates[favourite].Of(voter.criterion)) {
        favourite = i;
      }
      for (const ScoredTile& other : candidates) {
        const double rival = other.Of(voter.criterion);
        if (std::isnan(rival) ? true : rival < score) ranking.tiles[i].borda += voter.weight;
      }
    }
    if (favourite < candidates.size()) ranking.tiles[favourite].votes += voter.weight;
  }
  if (rule == VoteRule::kBorda) {
    for (RankedTile& ranked : ranking.tiles) ranked.votes = ranked.borda;
  }
  std::stable_sort(ranking.tiles.begin(), ranking.tiles.end(),
                   [](const RankedTile& a, const RankedTile& b) {
                     return a.votes != b.votes ? a.votes > b.votes : a.borda > b.borda;
                   });
  return ranking;
}

}  // namespace secondlook::planning
