#pragma once

#include <vector>

#include "lib/fusion/conclude.h"
#include "lib/world/object_belief.h"
#include "lib/world/task.h"

namespace secondlook::apps {

/// What may be true of an object, as far as the choice of a look asks.
struct GuidingHypothesis {
  const world::PoseHypothesis* hypothesis{};  ///< Not null; of the object.
  double probability{};                       ///< That it is true, in [0, 1].
};

/// Those few hypotheses of `object` that may well be true, best first: the poses that fit nearly as
/// well as the best one, and the best of each class that is believed in. What is believed of a
/// class is shared among its poses by how far the views prefer one to the other. Empty when no
/// model fits. The probabilities sum to at most 1; the rest is for what is none of them.
std::vector<GuidingHypothesis> LikelyHypotheses(const world::ObjectBelief& object,
                                                const fusion::ConcludeConfig& config);

/// The rivals of the `likely` ones, as many as there is room for: what fits worst, or a view
/// struck. They are out of the question only as far as the views are believed, and the chance that
/// all of these misled (by their reliability) is shared evenly by the rivals and what is none of
/// all. So a thing is not confirmed from where its twin looks the same. With the likely ones, their
/// probabilities sum to at most 1.
std::vector<GuidingHypothesis> Rivals(const world::ObjectBelief& object,
                                      const std::vector<GuidingHypothesis>& likely,
                                      const fusion::ConcludeConfig& config);

/// The probability from which on `object` is concluded to be `hypothesis`, one of its own: what
/// `task` asks of the class and, as a posterior, the lead that it needs over the other poses of its
/// model.
double NeededProbability(const world::PoseHypothesis& hypothesis, const world::ObjectBelief& object,
                         const world::Task& task, const fusion::ConcludeConfig& config);

}  // namespace secondlook::apps
