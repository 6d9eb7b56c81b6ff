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

Estimate BootstrappedMean(const std::vector<double>& values) {
  return BootstrappedRatio(values, std::vector<double>(values.size(), 1.0));
}

Estimate BootstrappedRatio(const std::vector<double>& numerators,
                           const std::vector<double>& denominators) {
  constexpr int kResamples = 2000;
  const int count = static_cast<int>(numerators.size());
  if (count == 0) return {kNone, kNone, kNone};
  Rng rng(1);
  std::vector<double> ratios(kResamples);
  for (double& ratio : ratios) {
    double above = 0.0;
    double below = 0.0;
    for (int i = 0; i < count; ++i) {
      const int drawn = rng.Index(count);
      above += numerators[drawn];
      below += denominators[drawn];
    }
    ratio = above / below;
  }
  std::sort(ratios.begin(), ratios.end());
  const double value = std::accumulate(numerators.begin(), numerators.end(), 0.0) /
                       std::accumulate(denominators.begin(), denominators.end(), 0.0);
  return {value, ratios[kResamples / 40], ratios[kResamples - 1 - kResamples / 40]};
}

}  // namespace secondlook::apps
