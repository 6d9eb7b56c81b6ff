#include "lib/perception/posterior.h"

#include <algorithm>
#include <cmath>

#include "lib/common/check_range.h"
#include "lib/perception/verify.h"

namespace secondlook::perception {
namespace {

double LogWeight(const PosteriorConfig& config, const world::Hypothesis& h) {
  return config.slope * LogOdds(h.score) - (h.verification.accepted ? 0.0 : config.failed_check);
}

}  // namespace

void PosteriorConfig::Validate() const {
  CheckRange(slope, 0.0, 10.0, "slope");
  CheckRange(none, -100.0, 100.0, "none");
  CheckRange(failed_check, 0.0, 100.0, "failed_check");
  CheckRange(doubt, 0.0, 1.0, "doubt");
}

void SetProbabilities(const PosteriorConfig& config, std::vector<world::Hypothesis>* hypotheses) {
  double largest = config.none;
  for (const world::Hypothesis& h : *hypotheses) largest = std::max(largest, LogWeight(config, h));
  double sum = std::exp(config.none - largest);
  for (const world::Hypothesis& h : *hypotheses) sum += std::exp(LogWeight(config, h) - largest);
  for (world::Hypothesis& h : *hypotheses) {
    h.probability = (1.0 - config.doubt) * std::exp(LogWeight(config, h) - largest) / sum;
  }
}

double ProbabilityOf(const std::string& model, const std::vector<world::Hypothesis>& hypotheses) {
  double probability = 0.0;
  for (const world::Hypothesis& h : hypotheses) {
    if (h.model == model) probability += h.probability;
  }
  return probability;
}

}  // namespace secondlook::perception
