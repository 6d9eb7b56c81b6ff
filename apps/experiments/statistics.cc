#include "apps/experiments/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "lib/common/rng.h"

namespace secondlook::apps {
namespace {

constexpr double kZ95 = 1.959963984540054;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

}  // namespace

Estimate Proportion(int hits, int count) {
  if (count == 0) return {kNone, 0.0, 1.0};
  const double n = count;
  const double p = hits / n;
  const double z2 = kZ95 * kZ95;
  const double center = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
  const double half = kZ95 / (1.0 + z2 / n) * std::sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n));
  return {p, std::max(0.0, center - half), std::min(1.0, center + half)};
}

Estimate Mean(const std::vector<double>& values) {
  if (values.empty()) return {kNone, kNone, kNone};
  const double n = static_cast<double>(values.size());
  double mean = 0.0;
  for (const double value : values) mean += value / n;
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  const double half = n > 1.0 ? kZ95 * std::sqrt(sum / (n - 1.0) / n) : 0.0;
  return {mean, mean - half, mean + half};
}

Estimate Bootstrapped(int count, const std::function<double(const std::vector<int>&)>& figure) {
  constexpr int kResamples = 2000;
  if (count == 0) return {kNone, kNone, kNone};
  Rng rng(1);
  std::vector<int> trials(count);
  std::vector<double> figures(kResamples);
  for (double& resampled : figures) {
    for (int& trial : trials) trial = rng.Index(count);
    resampled = figure(trials);
  }
  std::sort(figures.begin(), figures.end());
  std::iota(trials.begin(), trials.end(), 0);
  return {figure(trials), figures[kResamples / 40], figures[kResamples - 1 - kResamples / 40]};
}

Estimate BootstrappedMean(const std::vector<double>& values) {
  return BootstrappedRatio(values, std::vector<double>(values.size(), 1.0));
}

Estimate BootstrappedRatio(const std::vector<double>& numerators,
                           const std::vector<double>& denominators) {
  return Bootstrapped(static_cast<int>(numerators.size()), [&](const std::vector<int>& trials) {
    double above = 0.0;
    double below = 0.0;
    for (const int trial : trials) {
      above += numerators[trial];
      below += denominators[trial];
    }
    return above / below;
  });
}

}  // namespace secondlook::apps
