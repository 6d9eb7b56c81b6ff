#include "apps/experiments/reliability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lib/common/rng.h"

namespace secondlook::apps {
namespace {

struct Bin {
  int count{};
  int right{};
  double probabilities{};  ///< Their sum.
};

using Bins = std::array<Bin, kReliabilityBins>;

int BinOf(double probability) {
  return std::clamp(static_cast<int>(probability * kReliabilityBins), 0, kReliabilityBins - 1);
}

Bins Count(const Predictions& predictions) {
  Bins bins{};
  for (const Prediction& p : predictions) {
    Bin& bin = bins[BinOf(p.probability)];
    ++bin.count;
    bin.right += p.right ? 1 : 0;
    bin.probabilities += p.probability;
  }
  return bins;
}

Bins Sum(const Bins& a, const Bins& b) {
  Bins sum = a;
  for (int i = 0; i < kReliabilityBins; ++i) {
    sum[i].count += b[i].count;
    sum[i].right += b[i].right;
    sum[i].probabilities += b[i].probabilities;
  }
  return sum;
}

double ErrorOf(const Bins& bins) {
  double error = 0.0;
  int count = 0;
  for (const Bin& bin : bins) {
    error += std::abs(bin.probabilities - bin.right);
    count += bin.count;
  }
  return count > 0 ? error / count : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Estimate ShareRight(const std::vector<Predictions>& trials, int bin) {
  Bins bins{};
  for (const Predictions& trial : trials) bins = Sum(bins, Count(trial));
  return Proportion(bins[bin].right, bins[bin].count);
}

Estimate CalibrationError(const std::vector<Predictions>& trials) {
  constexpr int kResamples = 2000;
  std::vector<Bins> by_trial;
  Bins all{};
  for (const Predictions& trial : trials) {
    if (trial.empty()) continue;
    by_trial.push_back(Count(trial));
    all = Sum(all, by_trial.back());
  }
  const double value = ErrorOf(all);
  if (by_trial.empty()) return {value, value, value};
  Rng rng(1);
  std::vector<double> errors(kResamples);
  for (double& error : errors) {
    Bins drawn{};
    for (std::size_t i = 0; i < by_trial.size(); ++i) {
      drawn = Sum(drawn, by_trial[rng.Index(static_cast<int>(by_trial.size()))]);
    }
    error = ErrorOf(drawn);
  }
  std::sort(errors.begin(), errors.end());
  return {value, errors[kResamples / 40], errors[kResamples - 1 - kResamples / 40]};
}

Estimate BrierScore(const std::vector<Predictions>& trials) {
  std::vector<double> sums;
  std::vector<double> counts;
  for (const Predictions& trial : trials) {
    if (trial.empty()) continue;
    sums.push_back(0.0);
    for (const Prediction& p : trial) {
      const double error = p.probability - (p.right ? 1.0 : 0.0);
      sums.back() += error * error;
    }
    counts.push_back(static_cast<double>(trial.size()));
  }
  return BootstrappedRatio(sums, counts);
}

}  // namespace secondlook::apps
