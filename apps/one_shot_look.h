#pragma once

#include <optional>
#include <vector>

#include "lib/perception/appearance/classifier.h"
#include "lib/planning/expected_loss.h"
#include "lib/world/look.h"
#include "lib/world/scene_belief.h"
#include "lib/world/task.h"

namespace secondlook::apps {

/// What is believed of an object's class: the classes of its masses with a share worth a thought,
/// and last what is none of them.
planning::Belief ClassBelief(const world::ObjectBelief& object, const world::Task& task);

/// The drop of the loss that one more picture of the object is expected to bring, by a classifier
/// that is right with the probability `accuracy` and otherwise names any other of its classes: the
/// evidence for one of `classes` against another is the divergence of what it says of the two. It
/// has none for or against what is none of its classes.
double ClassificationGain(const world::ObjectBelief& object, const world::Task& task,
                          const std::vector<std::string>& classes, double accuracy,
                          const planning::LossConfig& loss);

/// The look that the one-shot vote (Hoseini 2021, Section 4) asks for: the side that the tiles of
/// the object's newest picture rank first, of those that any of `looks` can take. It is a copy of
/// the look nearest to TileView(), of the kind "one_shot"; its gain is that look's own or what the
/// picture brings, whichever is more. None where the class is sure enough already, the object has
/// no picture, no tile is a candidate, or no look goes to one.
/// @param looks Feasible and refused ones of any target; those of `object` count.
/// @param view_reliability How far one more view is to be trusted at all.
/// @param look_seconds What a look takes beside getting there.
std::optional<world::Look> OneShotLook(const world::SceneBelief& scene,
                                       const world::ObjectBelief& object, const world::Task& task,
                                       const perception::Classifier& classifier,
                                       double view_reliability, const planning::LossConfig& loss,
                                       double look_seconds, const std::vector<world::Look>& looks);

}  // namespace secondlook::apps
