#pragma once

#include <array>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "apps/experiments/nbv_sets.h"
#include "lib/fusion/decision_fusion.h"

namespace secondlook::apps::nbv {

inline constexpr std::array kRules{
    std::pair{fusion::FusionRule::kNaiveBayes, "naive Bayes"},
    std::pair{fusion::FusionRule::kAveraging, "averaging"},
    std::pair{fusion::FusionRule::kTransferableBelief, "belief masses"}};

/// What is decided of an object.
struct Decision {
  int said{};                         ///< Index of the class; -1 in total conflict.
  double confidence{};                ///< Its probability.
  double of_truth{};                  ///< The true class's probability.
  double ratio{};                     ///< The largest probability over the second.
  std::vector<double> probabilities;  ///< By class; empty in total conflict.
};

/// What is decided of a case.
struct Decided {
  Decision front;                         ///< By the first view alone.
  std::array<Decision, kSideCount> with;  ///< By the side that was looked from, too.
};

/// How much each side is looked from; they sum to 1.
using Choice = std::array<double, kSideCount>;
using Chooser = std::function<Choice(int set, int which)>;

/// One of the decisions of a case for a way to choose, and the share in which it comes about.
struct Shared {
  double share;
  const Decision* decision;
};

/// What is decided of every case, by every rule, from every side. Sets and their cases are meant by
/// their index.
class Decisions {
 public:
  /// @param sets, classifier Must outlive it.
  Decisions(const std::vector<NbvSet>& sets, const NbvClassifier& classifier);

  const std::vector<NbvSet>& sets() const { return sets_; }
  int set_count() const { return static_cast<int>(sets_.size()); }
  const Decided& Of(fusion::FusionRule rule, int set, int which) const {
    return decided_.at(rule)[set][which];
  }

  /// What naive Bayes decides of a set by the view from a side alone.
  Decision FromSide(int set, std::size_t side) const;

  /// What comes of looking from the sides that `chooser` says, where the first view's ratio is
  /// below `gate`.
  std::vector<Shared> Result(fusion::FusionRule rule, const Chooser& chooser, int set, int which,
                             double gate) const;

  /// By set: how many of its cases are right; `wanted`: of which distortion, -1 all.
  std::vector<double> Right(fusion::FusionRule rule, const Chooser& chooser, double gate = kAlways,
                            int wanted = -1) const;

  /// By set: the number of cases, likewise.
  std::vector<double> Count(int wanted = -1) const;

  /// m(empty) of the first view of a case and the view of a side, of two sets or of one.
  double Conflict(int front_set, int which, int side_set, std::size_t side) const;

  static constexpr double kAlways = std::numeric_limits<double>::infinity();
  static constexpr double kNever = 0.0;

 private:
  fusion::ViewDecision View(const std::vector<double>& probabilities,
                            fusion::FusionRule rule) const;
  Decision DecisionOf(const std::map<std::string, double>& p, int truth) const;
  Decided Decide(fusion::FusionRule rule, const NbvSet& set, const NbvCase& one) const;

  const std::vector<NbvSet>& sets_;
  const NbvClassifier& classifier_;
  std::map<fusion::FusionRule, std::vector<std::vector<Decided>>> decided_;
};

}  // namespace secondlook::apps::nbv
