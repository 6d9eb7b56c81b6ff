#include "lib/fusion/dempster_shafer.h"

#include <algorithm>

#include "lib/common/error.h"

namespace secondlook::fusion {
namespace {

/// Support that leaves no room for doubt would be beyond what any later view can correct.
constexpr double kMaxSupport = 0.999;

}  // namespace

world::MassFunction FromSupports(const std::map<std::string, double>& supports) {
  // By Dempster's rule m({c}) is proportional to s_c times the product of the others' 1 - s, and
  // m(Omega) to the product of all 1 - s. Divided by that product, they are odds.
  world::MassFunction m;
  double total = 1.0;
  for (const auto& [c, support] : supports) {
    if (!(support >= 0.0 && support <= 1.0)) {
      Throw<InvalidArgument>("the support of class '{}' is {}; it must lie in [0, 1]", c, support);
    }
    if (support == 0.0) continue;
    const double s = std::min(support, kMaxSupport);
    m.singletons[c] = s / (1.0 - s);
    total += m.singletons[c];
  }
  for (auto& [c, mass] : m.singletons) mass /= total;
  m.omega = 1.0 / total;
  return m;
}

world::MassFunction Combine(const world::MassFunction& a, const world::MassFunction& b) {
  world::MassFunction m;
  m.omega = a.omega * b.omega;
  double sum = m.omega;
  for (const auto* operand : {&a, &b}) {
    for (const auto& [c, mass] : operand->singletons) {
      const double product = a.Of(c) * b.Of(c) + a.Of(c) * b.omega + a.omega * b.Of(c);
      if (m.singletons.emplace(c, product).second) sum += product;
    }
  }
  m.conflict = std::clamp(1.0 - sum, 0.0, 1.0);
  return m;
}

world::MassFunction Discounted(world::MassFunction m, double reliability) {
  for (auto& [c, mass] : m.singletons) mass *= reliability;
  m.conflict *= reliability;
  m.omega = 1.0 - reliability * (1.0 - m.omega);
  return m;
}

double CommittedConflict(const world::MassFunction& a, const world::MassFunction& b) {
  const double most = (1.0 - a.omega) * (1.0 - b.omega);
  return most > 0.0 ? std::min(Combine(a, b).conflict / most, 1.0) : 0.0;
}

std::map<std::string, double> Pignistic(const world::MassFunction& m, int class_count) {
  const double share = m.omega / class_count;
  std::map<std::string, double> probabilities;
  for (const auto& [c, mass] : m.singletons) {
    probabilities[c] = (mass + share) / (1.0 - m.conflict);
  }
  return probabilities;
}

double NormalisedBelief(const world::MassFunction& m, const std::string& c) {
  return m.conflict < 1.0 ? m.Of(c) / (1.0 - m.conflict) : 0.0;
}

double NormalisedIgnorance(const world::MassFunction& m) {
  return m.conflict < 1.0 ? m.omega / (1.0 - m.conflict) : 1.0;
}

}  // namespace secondlook::fusion
