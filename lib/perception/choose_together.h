#pragma once

#include <vector>

#include "lib/perception/recognise.h"

namespace secondlook::perception {

/// How much of `model` at X_CM stands in `other` at X_CO, as solid things do not: the share of its
/// points, taken 8 mm below its surface, that lie behind the nearest surface of the other. The
/// meshes need not be closed.
double ShareInside(const RecognitionModel& model, const Pose& X_CM, const RecognitionModel& other,
                   const Pose& X_CO);

/// Chooses for all detections of a view at once. What is beyond doubt alone (ChooseHypotheses())
/// speaks for the rest: a hypothesis that would stand in a chosen thing of another cluster is
/// struck, which may settle what was open between it and another; of two chosen ones that stand in
/// one another the better stays, and what the loser's cluster falls back to is asked again. So each
/// part of space is explained once. Pieces of one thing (one model at one pose, in two clusters)
/// count once, too. Deterministic; the reasons say what gave way to what.
/// @param models Every model that `detections` names.
std::vector<Choice> ChooseTogether(const std::vector<world::Detection>& detections,
                                   const std::vector<RecognitionModel>& models,
                                   const RecogniseConfig& config);

}  // namespace secondlook::perception
