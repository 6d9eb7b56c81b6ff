#pragma once

#include <array>
#include <functional>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "apps/experiments/nbv_decisions.h"

namespace secondlook::apps::nbv {

/// What looks that were logged lead to expect of the next: which side tells the classes apart
/// between which the first view is unsure.
class Experience {
 public:
  /// Of the sets for which `learn` holds.
  Experience(const Decisions& decisions, const std::function<bool(int)>& learn);

  /// By side: how probable the true class is expected to become by naive Bayes. The mean over the
  /// classes, as probable as the first view holds them, and over the logged views of each from that
  /// side; a class without logged views stays as probable as it is.
  /// @param front Probabilities by class.
  Eigen::VectorXd Expected(const std::vector<double>& front) const;

 private:
  std::vector<std::array<Eigen::MatrixXd, kSideCount>> views_;  // by class; a column each
};

/// For each block of sets the experience of other blocks.
class ExperienceOfOthers {
 public:
  /// @param decisions Must outlive it.
  explicit ExperienceOfOthers(const Decisions& decisions);

  /// As Experience::Expected, of a case, by all blocks but its own and `tested`.
  Eigen::VectorXd Expected(int set, int which, int tested) const;

  /// How much more probable the true class is expected to become by looking from the best side than
  /// the first view's best class is; below 0 where little is to be expected.
  double Promise(int set, int which) const;

 private:
  const Decisions& decisions_;
  std::map<std::pair<int, int>, Experience> without_;  // by the two blocks that are left out
};

/// The blocks that there are sets of.
std::set<int> Blocks(const Decisions& decisions);

}  // namespace secondlook::apps::nbv
