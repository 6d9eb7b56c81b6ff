#include "lib/world/object_belief.h"

namespace secondlook::world {

const char* ToString(ObjectState state) {
  switch (state) {
    case ObjectState::kCandidate:
      return "candidate";
    case ObjectState::kVerified:
      return "verified";
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

}  // namespace secondlook::world
