#include "apps/experiments/nbv_choosers.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "apps/experiments/nbv_experience.h"

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

/// What a learned chooser goes by: how each side's tile scores among the five, for as much as the
/// first view leaves open, and what experience expects.
constexpr int kFeatures = planning::kCriteria + 2;

/// @param expected By side.
Eigen::MatrixXd Features(const NbvCase& one, const Decision& front, Eigen::VectorXd expected) {
  Eigen::MatrixXd features = Eigen::MatrixXd::Zero(kSideCount, kFeatures);
  for (int f = 0; f < planning::kCriteria + 1; ++f) {
    Eigen::VectorXd scores(kSideCount);
    for (std::size_t s = 0; s < kSideCount; ++s) {
      scores[s] = f < planning::kCriteria ? one.sides[s].scores[f] : one.sides[s].foreground;
    }
    if (!scores.allFinite()) continue;
    scores.array() -= scores.mean();
    const double deviation = std::sqrt(scores.squaredNorm() / kSideCount);
    if (deviation > 1e-9) features.col(f) = (1.0 - front.confidence) * scores / deviation;
  }
  constexpr double kExpectedScale = 10.0;  // of the size of the others, as all are shrunk alike
  expected.array() -= expected.mean();
  features.rightCols(1) = kExpectedScale * expected;
  return features;
}

/// Which side to look from, learnt by ridge regression from the features to how much more probable
/// than from the other sides the true class becomes, from all blocks but that of the case.
class LearnedChooser {
 public:
  explicit LearnedChooser(const Decisions& decisions)
      : decisions_(decisions), experience_(decisions) {
    std::map<int, Eigen::VectorXd> weights;
    for (const int block : Blocks(decisions)) weights[block] = LearnWithout(block);
    for (int i = 0; i < decisions.set_count(); ++i) {
      const int block = decisions.sets()[i].block;
      auto& best = best_.emplace_back();
      for (int k = 0; k < std::ssize(decisions.sets()[i].cases); ++k) {
        (FeaturesOf(i, k, block) * weights.at(block)).maxCoeff(&best.emplace_back());
      }
    }
  }

  std::size_t Best(int set, int which) const { return static_cast<std::size_t>(best_[set][which]); }

 private:
  const Decided& Of(int set, int which) const {
    return decisions_.Of(FusionRule::kNaiveBayes, set, which);
  }

  /// Without what block `tested` would tell.
  Eigen::MatrixXd FeaturesOf(int set, int which, int tested) const {
    return Features(decisions_.sets()[set].cases[which], Of(set, which).front,
                    experience_.Expected(set, which, tested));
  }

  Eigen::VectorXd LearnWithout(int block) const {
    constexpr double kRidge = 300.0;  // cases
    Eigen::MatrixXd products = kRidge * Eigen::MatrixXd::Identity(kFeatures, kFeatures);
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(kFeatures);
    for (int i = 0; i < decisions_.set_count(); ++i) {
      if (decisions_.sets()[i].block == block) continue;
      for (int k = 0; k < std::ssize(decisions_.sets()[i].cases); ++k) {
        Eigen::VectorXd gain(kSideCount);
        for (std::size_t s = 0; s < kSideCount; ++s) gain[s] = Of(i, k).with[s].of_truth;
        gain.array() -= gain.mean();
        const Eigen::MatrixXd features = FeaturesOf(i, k, block);
        products += features.transpose() * features;
        sums += features.transpose() * gain;
      }
    }
    return products.ldlt().solve(sums);
  }

  const Decisions& decisions_;
  ExperienceOfOthers experience_;
  std::vector<std::vector<Eigen::Index>> best_;  // by set and case
};

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
  if (Blocks(decisions).size() > 1) {
    const auto learned = std::make_shared<LearnedChooser>(decisions);
    choosers.push_back(
        {"learned", [learned](int set, int which) { return Only(learned->Best(set, which)); }});
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
