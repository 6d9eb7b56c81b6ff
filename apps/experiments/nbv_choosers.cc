#include "apps/experiments/nbv_choosers.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>
#include <Eigen/Dense>

namespace secondlook::apps::nbv {
namespace {

using fusion::FusionRule;
using planning::Criterion;
using planning::ScoredTile;

constexpr std::array kCriterionNames{
    "variance",      "third moment", "parallelism", "light",           "metric parallelism",
    "dissimilarity", "uniformity",   "entropy",     "information gain"};
static_assert(kCriterionNames.size() == planning::kCriteria);

constexpr Choice kAnySide{0.2, 0.2, 0.2, 0.2, 0.2};

Choice Only(std::size_t side) {
  Choice choice{};
  choice[side] = 1.0;
  return choice;
}

/// What a learned chooser goes by: which side it is, and how it scores among the five.
constexpr int kFeatures = static_cast<int>(kSideCount) + planning::kCriteria + 1;

Eigen::MatrixXd Features(const NbvCase& one) {
  Eigen::MatrixXd features = Eigen::MatrixXd::Zero(kSideCount, kFeatures);
  features.leftCols<kSideCount>().setIdentity();
  for (int f = 0; f < planning::kCriteria + 1; ++f) {
    Eigen::VectorXd scores(kSideCount);
    for (std::size_t s = 0; s < kSideCount; ++s) {
      scores[s] = f < planning::kCriteria ? one.sides[s].scores[f] : one.sides[s].foreground;
    }
    if (!scores.allFinite()) continue;
    scores.array() -= scores.mean();
    const double deviation = std::sqrt(scores.squaredNorm() / kSideCount);
    if (deviation > 1e-9) features.col(kSideCount + f) = scores / deviation;
  }
  return features;
}

/// Ridge regression from features to how much more probable than from the other sides the true
/// class becomes on average, learnt from the sets for which `learn` holds.
Eigen::VectorXd LearnGain(const Decisions& decisions, const std::function<bool(int)>& learn) {
  constexpr double kRidge = 100.0;  // cases
  Eigen::MatrixXd products = kRidge * Eigen::MatrixXd::Identity(kFeatures, kFeatures);
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(kFeatures);
  for (int i = 0; i < decisions.set_count(); ++i) {
    if (!learn(i)) continue;
    for (int k = 0; k < std::ssize(decisions.sets()[i].cases); ++k) {
      const Decided& decided = decisions.Of(FusionRule::kNaiveBayes, i, k);
      Eigen::VectorXd gain(kSideCount);
      for (std::size_t s = 0; s < kSideCount; ++s) {
        gain[s] = decided.with[s].of_truth;
      }
      gain.array() -= gain.mean();
      const Eigen::MatrixXd features = Features(decisions.sets()[i].cases[k]);
      products += features.transpose() * features;
      sums += features.transpose() * gain;
    }
  }
  return products.ldlt().solve(sums);
}

/// By block: what was learnt from all others.
std::map<int, Eigen::VectorXd> LearnGains(const Decisions& decisions) {
  std::map<int, Eigen::VectorXd> weights;
  for (const NbvSet& set : decisions.sets()) weights.try_emplace(set.block);
  if (weights.size() < 2) return {};
  for (auto& [block, w] : weights) {
    const int tested = block;
    w = LearnGain(decisions, [&](int i) { return decisions.sets()[i].block != tested; });
  }
  return weights;
}

}  // namespace

Choice Vote(const std::array<ScoredTile, kSideCount>& sides,
            const std::vector<planning::Voter>& voters, planning::VoteRule rule, bool refuse,
            std::size_t rank) {
  std::vector<ScoredTile> tiles(sides.begin(), sides.end());
  if (!refuse) {
    for (ScoredTile& tile : tiles) tile.refusal.clear();
  }
  const planning::TileRanking ranking = RankTiles(tiles, voters, rule);
  if (ranking.tiles.size() <= rank) return kAnySide;
  const auto* const side = std::find(kSides.begin(), kSides.end(), ranking.tiles[rank].tile);
  return Only(static_cast<std::size_t>(side - kSides.begin()));
}

std::vector<NamedChooser> Choosers(const Decisions& decisions) {
  const auto sides = [&](int set, int which) -> const auto& {
    return decisions.sets()[set].cases[which].sides;
  };
  std::vector<NamedChooser> choosers;
  choosers.push_back({"random side", [](int, int) { return kAnySide; }});
  for (std::size_t s = 0; s < kSideCount; ++s) {
    choosers.push_back(
        {fmt::format("always {}", TileName(kSides[s])), [s](int, int) { return Only(s); }});
  }
  for (int c = 0; c < planning::kCriteria; ++c) {
    choosers.push_back({kCriterionNames[c], [=](int set, int which) {
                          return Vote(sides(set, which), {{static_cast<Criterion>(c)}},
                                      planning::VoteRule::kPlurality, false);
                        }});
  }
  choosers.push_back({"paper's vote", [=](int set, int which) {
                        return Vote(sides(set, which), planning::PaperVoters(),
                                    planning::VoteRule::kPlurality, false);
                      }});
  choosers.push_back(
      {"our vote", [=](int set, int which) {
         return Vote(sides(set, which),
                     {{Criterion::kVariance}, {Criterion::kMetricParallelism}, {Criterion::kLight}},
                     planning::VoteRule::kBorda, true);
       }});
  if (auto weights = LearnGains(decisions); !weights.empty()) {
    choosers.push_back({"learned", [&decisions, weights](int set, int which) {
                          const NbvSet& all = decisions.sets()[set];
                          Eigen::Index best = 0;
                          (Features(all.cases[which]) * weights.at(all.block)).maxCoeff(&best);
                          return Only(static_cast<std::size_t>(best));
                        }});
  }
  choosers.push_back({"oracle", [&decisions](int set, int which) {
                        const auto& with = decisions.Of(FusionRule::kNaiveBayes, set, which).with;
                        const auto* const best = std::max_element(
                            with.begin(), with.end(), [](const Decision& a, const Decision& b) {
                              return a.of_truth < b.of_truth;
                            });
                        return Only(static_cast<std::size_t>(best - with.begin()));
                      }});
  return choosers;
}

}  // namespace secondlook::apps::nbv
