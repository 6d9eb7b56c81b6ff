#include "apps/guiding_hypotheses.h"

#include <algorithm>
#include <cmath>

#include "lib/fusion/dempster_shafer.h"

namespace secondlook::apps {
namespace {

using world::ObjectBelief;
using world::PoseHypothesis;

/// Below this support of the best one, no model fits at all.
constexpr double kMinSupport = 0.15;
/// With less than this share of the best one's support a hypothesis is but a rival, unless it is
/// the best of a class that is believed so much: what must be told from it, though it fits worse.
constexpr double kMinSupportShare = 0.3;
constexpr double kMinBelief = 0.01;
constexpr std::size_t kMaxHypotheses = 4;

/// Those that may well be true, in the order of `object`.
std::vector<const PoseHypothesis*> Likely(const ObjectBelief& object) {
  std::vector<const PoseHypothesis*> likely;
  for (const PoseHypothesis& h : object.hypotheses) {
    if (h.struck || likely.size() == kMaxHypotheses) break;
    const bool another_class =
        std::none_of(likely.begin(), likely.end(),
                     [&](const PoseHypothesis* other) { return other->model == h.model; });
    const bool believed =
        another_class && fusion::NormalisedBelief(object.masses, h.model) >= kMinBelief;
    if (believed || h.support >= kMinSupportShare * object.Best()->support) likely.push_back(&h);
  }
  return likely;
}

}  // namespace

std::vector<GuidingHypothesis> LikelyHypotheses(const ObjectBelief& object,
                                                const fusion::ConcludeConfig& config) {
  const PoseHypothesis* best = object.Best();
  if (best == nullptr || best->support < kMinSupport) return {};
  const std::vector<const PoseHypothesis*> likely = Likely(object);
  std::vector<GuidingHypothesis> guiding;
  for (const PoseHypothesis* h : likely) {
    double odds = 0.0;  // of all poses of its class, against it
    for (const PoseHypothesis* other : likely) {
      if (other->model == h->model) odds += std::exp(fusion::Lead(config, *other, *h));
    }
    guiding.push_back({h, fusion::NormalisedBelief(object.masses, h->model) / odds});
  }
  return guiding;
}

std::vector<GuidingHypothesis> Rivals(const ObjectBelief& object,
                                      const std::vector<GuidingHypothesis>& likely,
                                      const fusion::ConcludeConfig& config) {
  std::vector<GuidingHypothesis> rivals;
  if (likely.empty()) return rivals;
  for (const PoseHypothesis& h : object.hypotheses) {
    if (likely.size() + rivals.size() == kMaxHypotheses) break;
    const bool is_likely = std::any_of(likely.begin(), likely.end(),
                                       [&](const auto& other) { return other.hypothesis == &h; });
    if (!is_likely) rivals.push_back({&h, 0.0});
  }
  const double misled =
      std::pow(1.0 - config.view_reliability, static_cast<double>(object.sightings.size()));
  for (GuidingHypothesis& rival : rivals) {
    rival.probability = misled / static_cast<double>(rivals.size() + 1);
  }
  return rivals;
}

double NeededProbability(const PoseHypothesis& hypothesis, const ObjectBelief& object,
                         const world::Task& task, const fusion::ConcludeConfig& config) {
  double needed = task.ConfidenceFor(hypothesis.model);
  for (const PoseHypothesis& other : object.hypotheses) {
    if (&other == &hypothesis || other.struck || other.model != hypothesis.model) continue;
    const double lead = fusion::NeededLead(config, hypothesis, other);
    needed = std::max(needed, 1.0 / (1.0 + std::exp(-lead)));
  }
  return needed;
}

}  // namespace secondlook::apps
