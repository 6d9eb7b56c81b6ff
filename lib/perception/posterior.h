#pragma once

#include <string>
#include <vector>

#include "lib/world/hypothesis.h"

namespace secondlook::perception {

/// How the scores of a thing's hypotheses become probabilities. The values were fitted to simulated
/// single views, 40 of four crowded tables of `experiment recognition --seed 101`, by
/// `tools/fit_posterior` (docs/cli.md says how); no figure is measured on that seed, and a mission
/// never sees the truth.
struct PosteriorConfig {
  double slope = 0.36;        ///< What the log-odds of a score count by: scores are too sure.
  double none = 2.2;          ///< The logarithm of the weight of "it is none of these".
  double failed_check = 0.8;  ///< Taken off the log-odds of what is not accepted.
  double doubt = 0.003;       ///< The share of cases in which the view misleads, whatever it shows.

  template <class A>
  void Serialize(A* a) {
    a->Visit("slope", &slope);
    a->Visit("none", &none);
    a->Visit("failed_check", &failed_check);
    a->Visit("doubt", &doubt);
  }

  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// Sets Hypothesis::probability of all that one view holds for possible of one thing. The
/// hypotheses exclude each other and what is none of them: each has the weight
/// exp(slope * log-odds of its score - failed_check if it is not accepted), its probability is its
/// share of all weights, that of `none` included, less the share `doubt`. A function of the scores
/// and checks alone: their order does not matter, and together they never exceed 1 - `doubt`.
void SetProbabilities(const PosteriorConfig& config, std::vector<world::Hypothesis>* hypotheses);

/// The probability that the thing is `model`, in any of the poses: the sum over its hypotheses.
double ProbabilityOf(const std::string& model, const std::vector<world::Hypothesis>& hypotheses);

}  // namespace secondlook::perception
