#include "lib/planning/expected_loss.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lib/common/check_range.h"
#include "lib/common/error.h"

namespace secondlook::planning {
namespace {

/// A value of the standard normal distribution that stands for a share of it.
struct Luck {
  double sigmas;
  double probability;
};

/// Five-point Gauss-Hermite quadrature.
constexpr std::array<Luck, 5> kLuck{{{-2.8569700138728056, 0.0112574113277207},
                                     {-1.3556261799742659, 0.2220759220056126},
                                     {0.0, 0.5333333333333333},
                                     {1.3556261799742659, 0.2220759220056126},
                                     {2.8569700138728056, 0.0112574113277207}}};

/// What is believed when alternative `truth` is true and a view gave evidence for it.
Belief Posterior(const Belief& prior, const Eigen::MatrixXd& evidence, int truth, double sigmas) {
  Belief posterior = prior;
  double sum = 0.0;
  for (int i = 0; i < static_cast<int>(prior.alternatives.size()); ++i) {
    const double k = i == truth ? 0.0 : evidence(truth, i);
    double& p = posterior.alternatives[i].probability;
    p *= std::exp(-(k + std::sqrt(2.0 * k) * sigmas));
    sum += p;
  }
  for (Alternative& a : posterior.alternatives) a.probability /= sum;
  return posterior;
}

}  // namespace

void LossConfig::Validate() const {
  constexpr double kMost = 1e9;
  CheckRange(wrong, 0.0, kMost, "wrong");
  CheckRange(unsettled, 0.0, kMost, "unsettled");
  CheckRange(incomplete, 0.0, kMost, "incomplete");
  CheckRange(per_second, 0.0, kMost, "per_second");
}

double Loss(const Belief& belief, const LossConfig& config) {
  const double incomplete = config.incomplete * belief.incomplete;
  if (belief.alternatives.empty()) return incomplete;
  double least = config.unsettled;
  for (const Alternative& a : belief.alternatives) {
    const double wrong = std::max(config.wrong, config.unsettled / (1.0 - a.needed));
    least = std::min(least, wrong * (1.0 - a.probability));
  }
  return least + incomplete;
}

double ExpectedLoss(const std::vector<Outcome>& outcomes, const LossConfig& config) {
  double expected = 0.0;
  for (const Outcome& outcome : outcomes) {
    expected += outcome.probability * Loss(outcome.belief, config);
  }
  return expected;
}

std::vector<Outcome> Outcomes(const Belief& prior, const std::vector<Prospect>& prospects) {
  const int count = static_cast<int>(prior.alternatives.size());
  std::vector<Outcome> outcomes;
  for (const Prospect& prospect : prospects) {
    if (prospect.evidence.rows() != count || prospect.evidence.cols() != count ||
        !(count == 0 || prospect.evidence.minCoeff() >= 0.0)) {
      Throw<InvalidArgument>(
          "expected loss: the evidence of a prospect is {} x {} for {} alternatives; it must be "
          "square, of their number and not negative",
          prospect.evidence.rows(), prospect.evidence.cols(), count);
    }
    for (int truth = 0; truth < count; ++truth) {
      const double p = prior.alternatives[truth].probability;
      if (!(p > 0.0)) continue;
      for (const Luck& luck : kLuck) {
        outcomes.push_back({prospect.probability * p * luck.probability,
                            Posterior(prior, prospect.evidence, truth, luck.sigmas)});
      }
    }
  }
  return outcomes;
}

double GainPerSecond(const Belief& prior, const std::vector<Outcome>& outcomes, double seconds,
                     const LossConfig& config) {
  if (!(seconds > 0.0)) {
    Throw<InvalidArgument>("expected loss: a look of {} s; it must take time", seconds);
  }
  return (Loss(prior, config) - ExpectedLoss(outcomes, config)) / seconds;
}

}  // namespace secondlook::planning
