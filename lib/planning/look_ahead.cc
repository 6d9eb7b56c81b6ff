#include "lib/planning/look_ahead.h"

#include <algorithm>
#include <numeric>

#include "lib/common/check_range.h"

namespace secondlook::planning {
namespace {

std::vector<Prospect> Weakened(std::vector<Prospect> prospects, double share) {
  for (Prospect& prospect : prospects) prospect.evidence *= share;
  return prospects;
}

/// The indices of the `count` highest of `values`, the highest first, the first of equal ones.
std::vector<int> Highest(const std::vector<double>& values, int count) {
  std::vector<int> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return values[a] > values[b]; });
  order.resize(std::min(order.size(), static_cast<std::size_t>(count)));
  return order;
}

/// The gain per second of a look that takes `seconds`, turns out as in `outcomes`, and is followed
/// by a second one where that raises the gain per second.
double GainOfTwo(const Belief& prior, const std::vector<Outcome>& outcomes, double seconds,
                 const std::vector<Reading>& second, double second_seconds,
                 const LossConfig& loss) {
  double gain = Loss(prior, loss) - ExpectedLoss(outcomes, loss);
  const double gain_per_second = gain / seconds;
  for (const Outcome& outcome : outcomes) {
    const double most = Loss(outcome.belief, loss);
    if (most <= gain_per_second * second_seconds) continue;
    const double more = most - ExpectedLossAfter(outcome.belief, second, loss);
    if (more <= gain_per_second * second_seconds) continue;
    gain += outcome.probability * more;
    seconds += outcome.probability * second_seconds;
  }
  return gain / seconds;
}

}  // namespace

void LookAheadConfig::Validate() const {
  CheckRange(firsts, 0, 1000, "firsts");
  CheckRange(seconds, 0, 1000, "seconds");
}

std::vector<double> GainsLookingAhead(const Belief& prior, const std::vector<LookOption>& options,
                                      const std::function<Sequel(int first, int second)>& after,
                                      const LossConfig& loss, const LookAheadConfig& config) {
  const double at_stake = Loss(prior, loss);
  std::vector<std::vector<Outcome>> outcomes;
  std::vector<double> gains;  // per second
  std::vector<double> drops;
  for (const LookOption& option : options) {
    outcomes.push_back(Outcomes(prior, option.prospects));
    gains.push_back(GainPerSecond(prior, outcomes.back(), option.seconds, loss));
    drops.push_back(gains.back() * option.seconds);
  }
  const std::vector<int> seconds = Highest(drops, config.seconds);
  double best = gains.empty() ? 0.0 : *std::max_element(gains.begin(), gains.end());
  for (const int first : Highest(gains, config.firsts)) {
    if (at_stake <= best * options[first].seconds) continue;
    for (const int second : seconds) {
      const Sequel sequel = after(first, second);
      if (second == first || !(sequel.share > 0.0)) continue;
      const std::vector<Reading> readings =
          Readings(Weakened(options[second].prospects, sequel.share),
                   static_cast<int>(prior.alternatives.size()));
      const double gain =
          GainOfTwo(prior, outcomes[first], options[first].seconds, readings, sequel.seconds, loss);
      gains[first] = std::max(gains[first], gain);
    }
    best = std::max(best, gains[first]);
  }
  return gains;
}

}  // namespace secondlook::planning
