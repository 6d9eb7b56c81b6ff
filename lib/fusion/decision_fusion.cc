#include "lib/fusion/decision_fusion.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/common/error.h"
#include "lib/fusion/dempster_shafer.h"

namespace secondlook::fusion {
namespace {

using Probabilities = std::map<std::string, double>;

constexpr double kSumTolerance = 1e-6;

void CheckView(const ViewDecision& view, const ViewDecision& first, int number) {
  const world::MassFunction& m = view.masses;
  double sum = m.omega;
  if (!(m.omega >= 0.0)) {
    Throw<InvalidArgument>("view {}: m(Omega) is {}; a mass must be >= 0", number, m.omega);
  }
  for (const auto& [c, mass] : m.singletons) {
    if (!(mass >= 0.0)) {
      Throw<InvalidArgument>("view {}: class '{}' has the probability {}; it must be >= 0", number,
                             c, mass);
    }
    if (!first.masses.singletons.contains(c)) {
      Throw<InvalidArgument>(
          "view {}: class '{}' is none of view 1; views must be classified by the same classes",
          number, c);
    }
    sum += mass;
  }
  if (m.singletons.empty() || m.singletons.size() != first.masses.singletons.size()) {
    Throw<InvalidArgument>("view {}: has {} classes, view 1 has {}", number, m.singletons.size(),
                           first.masses.singletons.size());
  }
  if (!(std::abs(sum - 1.0) <= kSumTolerance)) {
    Throw<InvalidArgument>("view {}: its probabilities sum to {}, not to 1", number, sum);
  }
  if (m.conflict != 0.0) {
    Throw<InvalidArgument>("view {}: m(empty) = {}; a single view has no conflict", number,
                           m.conflict);
  }
  if (!(view.reliability >= 0.0 && view.reliability <= 1.0)) {
    Throw<InvalidArgument>("view {}: its reliability is {}; it must lie in [0, 1]", number,
                           view.reliability);
  }
}

/// Divided by their sum; none when that is 0.
Probabilities Normalised(Probabilities p) {
  double sum = 0.0;
  for (const auto& [c, probability] : p) sum += probability;
  if (sum == 0.0) return {};
  for (auto& [c, probability] : p) probability /= sum;
  return p;
}

Probabilities Even(const Probabilities& classes) {
  Probabilities even = classes;
  for (auto& [c, probability] : even) probability = 1.0 / static_cast<double>(classes.size());
  return even;
}

Probabilities Average(const std::vector<world::MassFunction>& views) {
  Probabilities sum;
  for (const world::MassFunction& view : views) {
    for (const auto& [c, mass] : view.singletons) sum[c] += mass;
  }
  const Probabilities average = Normalised(sum);
  return average.empty() ? Even(sum) : average;
}

Probabilities Product(const std::vector<world::MassFunction>& views) {
  const Probabilities& classes = views.front().singletons;
  Probabilities product = Even(classes);
  for (const world::MassFunction& view : views) {
    const double share = view.omega / static_cast<double>(classes.size());
    for (auto& [c, probability] : product) probability *= view.Of(c) + share;
    product = Normalised(product);  // at each view, so that many cannot underflow
  }
  return product;
}

/// The pignistic transform of the conjunctive combination; what is conflict is left out at each
/// view, which changes no ratio, so that many cannot underflow.
Probabilities Belief(const std::vector<world::MassFunction>& views) {
  world::MassFunction m;
  for (const world::MassFunction& view : views) {
    m = Combine(m, view);
    double possible = m.omega;
    for (const auto& [c, mass] : m.singletons) possible += mass;
    if (possible == 0.0) return {};
    for (auto& [c, mass] : m.singletons) mass /= possible;
    m.omega /= possible;
    m.conflict = 0.0;
  }
  return Pignistic(m, static_cast<int>(m.singletons.size()));
}

}  // namespace

FusedDecision FuseDecisions(FusionRule rule, const std::vector<ViewDecision>& views) {
  if (views.empty()) Throw<InvalidArgument>("no view to fuse; at least one is needed");
  std::vector<world::MassFunction> discounted;
  FusedDecision fused;
  for (int i = 0; i < std::ssize(views); ++i) {
    CheckView(views[i], views.front(), i + 1);
    discounted.push_back(Discounted(views[i].masses, views[i].reliability));
    fused.masses = Combine(fused.masses, discounted.back());
  }
  switch (rule) {
    case FusionRule::kAveraging:
      fused.probabilities = Average(discounted);
      break;
    case FusionRule::kNaiveBayes:
      fused.probabilities = Product(discounted);
      break;
    case FusionRule::kTransferableBelief:
      fused.probabilities = Belief(discounted);
      break;
  }
  return fused;
}

std::string MostProbable(const Probabilities& probabilities,
                         const std::vector<std::string>& except) {
  std::string best;
  double most = -1.0;
  for (const auto& [c, probability] : probabilities) {
    if (probability <= most || std::find(except.begin(), except.end(), c) != except.end()) continue;
    best = c;
    most = probability;
  }
  return best;
}

double ConfidenceRatio(const Probabilities& probabilities) {
  double first = 0.0;
  double second = 0.0;
  for (const auto& [c, probability] : probabilities) {
    second = std::max(second, std::min(first, probability));
    first = std::max(first, probability);
  }
  if (first == 0.0) return 0.0;
  return second == 0.0 ? std::numeric_limits<double>::infinity() : first / second;
}

}  // namespace secondlook::fusion
