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

/// What is believed when a view says this.
Belief Posterior(const Belief& prior, const std::vector<double>& likelihoods) {
  Belief posterior = prior;
  double sum = 0.0;
  for (std::size_t i = 0; i < likelihoods.size(); ++i) {
    double& p = posterior.alternatives[i].probability;
    p *= likelihoods[i];
    sum += p;
  }
  for (Alternative& a : posterior.alternatives) a.probability /= sum;
  return posterior;
}

/// The loss by a wrong decision for `a`.
double LossIfWrong(const Alternative& a, const LossConfig& config) {
  return std::max(config.wrong, config.unsettled / (1.0 - a.needed));
}

/// Loss() of Posterior().
double LossAfter(const Belief& prior, const std::vector<double>& likelihoods,
                 const LossConfig& config) {
  double sum = 0.0;
  for (std::size_t i = 0; i < likelihoods.size(); ++i) {
    sum += prior.alternatives[i].probability * likelihoods[i];
  }
  double least = config.unsettled;
  for (std::size_t i = 0; i < likelihoods.size(); ++i) {
    const Alternative& a = prior.alternatives[i];
    least = std::min(least, LossIfWrong(a, config) * (1.0 - a.probability * likelihoods[i] / sum));
  }
  return least + config.incomplete * prior.incomplete;
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
    least = std::min(least, LossIfWrong(a, config) * (1.0 - a.probability));
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

std::vector<Reading> Readings(const std::vector<Prospect>& prospects, int alternatives) {
  std::vector<Reading> readings;
  for (const Prospect& prospect : prospects) {
    const Eigen::MatrixXd& evidence = prospect.evidence;
    if (evidence.rows() != alternatives || evidence.cols() != alternatives ||
        !(alternatives == 0 || evidence.minCoeff() >= 0.0)) {
      Throw<InvalidArgument>(
          "expected loss: the evidence of a prospect is {} x {} for {} alternatives; it must be "
          "square, of their number and not negative",
          evidence.rows(), evidence.cols(), alternatives);
    }
    for (int truth = 0; truth < alternatives; ++truth) {
      for (const Luck& luck : kLuck) {
        Reading& reading = readings.emplace_back();
        reading.probability = prospect.probability * luck.probability;
        reading.truth = truth;
        for (int i = 0; i < alternatives; ++i) {
          const double k = i == truth ? 0.0 : evidence(truth, i);
          reading.likelihoods.push_back(std::exp(-(k + std::sqrt(2.0 * k) * luck.sigmas)));
        }
      }
    }
  }
  return readings;
}

std::vector<Outcome> Outcomes(const Belief& prior, const std::vector<Prospect>& prospects) {
  std::vector<Outcome> outcomes;
  for (const Reading& reading : Readings(prospects, static_cast<int>(prior.alternatives.size()))) {
    const double p = prior.alternatives[reading.truth].probability;
    if (!(p > 0.0)) continue;
    outcomes.push_back({p * reading.probability, Posterior(prior, reading.likelihoods)});
  }
  return outcomes;
}

double ExpectedLossAfter(const Belief& prior, const std::vector<Reading>& readings,
                         const LossConfig& config) {
  double expected = 0.0;
  for (const Reading& reading : readings) {
    const double p = prior.alternatives[reading.truth].probability;
    if (!(p > 0.0)) continue;
    expected += p * reading.probability * LossAfter(prior, reading.likelihoods, config);
  }
  return expected;
}

double GainPerSecond(const Belief& prior, const std::vector<Outcome>& outcomes, double seconds,
                     const LossConfig& config) {
  if (!(seconds > 0.0)) {
    Throw<InvalidArgument>("expected loss: a look of {} s; it must take time", seconds);
  }
  return (Loss(prior, config) - ExpectedLoss(outcomes, config)) / seconds;
}

}  // namespace secondlook::planning
