#include "lib/world/object_belief.h"

#include <algorithm>

namespace secondlook::world {

const char* ToString(ObjectState state) {
  switch (state) {
    case ObjectState::kCandidate:
      return "candidate";
    case ObjectState::kVerified:
      return "verified";
    case ObjectState::kClassified:
      return "classified";
    case ObjectState::kRejected:
      return "rejected";
    case ObjectState::kUnknown:
      return "unknown";
    case ObjectState::kModelling:
      return "modelling";
    case ObjectState::kModelled:
      return "modelled";
  }
  return "candidate";
}

const ViewEvidence* PoseHypothesis::BestView() const {
  const auto worse = [](const ViewEvidence& a, const ViewEvidence& b) {
    const Verification& va = a.hypothesis.verification;
    const Verification& vb = b.hypothesis.verification;
    return va.accepted != vb.accepted ? vb.accepted : va.matching < vb.matching;
  };
  const auto best = std::max_element(evidence.begin(), evidence.end(), worse);
  return best == evidence.end() ? nullptr : &*best;
}

std::string ObjectBelief::LeadingClass() const {
  const auto leader =
      std::max_element(masses.singletons.begin(), masses.singletons.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return leader == masses.singletons.end() ? "" : leader->first;
}

}  // namespace secondlook::world
