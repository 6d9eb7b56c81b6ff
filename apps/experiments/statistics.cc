#include "apps/experiments/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

}  // namespace secondlook::apps
