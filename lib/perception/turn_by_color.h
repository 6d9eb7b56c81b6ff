#pragma once

#include <vector>

#include "lib/perception/recognition_model.h"
#include "lib/perception/view.h"

namespace secondlook::perception {

/// The agreement (CompareColors) of the first `count` points of `model` at X_CM that face the
/// camera and lie at the measured depth; NaN where fewer than 20 do, or without colour.
double PointColorAgreement(const RecognitionModel& model, const Pose& X_CM, const View& view,
                           int label, int count);

/// The poses with the shape of `model` at X_CM, by its symmetry, whose colours are worth a closer
/// look: X_CM itself, each motion of the symmetry that changes the colour, and with a continuous
/// axis the turns (searched in steps of 5 degrees, then 1) at which the agreement has its highest
/// maxima. The best agreement first; at most `count`, count >= 1.
/// Without colour, or when no turn changes it, only X_CM.
std::vector<Pose> TurnByColor(const RecognitionModel& model, const Pose& X_CM, const View& view,
                              int label, int count);

/// Turns X_CM by a few degrees about three axes of M through the centre, in steps of 8 down to 1
/// degrees, to where colour and depth of the model's points agree best. Without colour: X_CM.
Pose PolishByColor(const RecognitionModel& model, Pose X_CM, const View& view, int label);

}  // namespace secondlook::perception
