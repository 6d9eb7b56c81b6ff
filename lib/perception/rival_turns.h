#pragma once

#include <vector>

#include "lib/common/pose.h"
#include "lib/perception/recognition_model.h"

namespace secondlook::perception {

/// The motions X_MS of the model frame after which `model` could be taken for itself, and which a
/// pose has to be told from before it counts as known: turns by +-`angle` [rad] about three axes
/// through the centre, and the motions of its symmetry of shape that change its colour, those about
/// a continuous axis in steps of 15 degrees. Motions that leave shape and colour unchanged are left
/// out: nothing tells them apart, and nothing needs to.
std::vector<Pose> RivalTurns(const RecognitionModel& model, double angle);

/// The rotations of a box about its middle that take the box of `model` nearly into itself: at them
/// a shape that is no symmetry may still be taken for itself (a brick with holes, laid on another
/// side). Those that leave shape and colour unchanged are left out.
std::vector<Pose> BoxTurns(const RecognitionModel& model);

/// `share` of the turn X_MS about `center_M`; a negative share turns the other way.
Pose ShareOfTurn(const Pose& X_MS, const Eigen::Vector3d& center_M, double share);

/// True when `model` at X_WM is about as it rests on a support plane with this normal (W, unit,
/// up).
bool IsAtRest(const RecognitionModel& model, const Pose& X_WM, const Eigen::Vector3d& normal_W);

/// True when `model` at X_WM rests on a support plane with this normal (W, unit, up) and turned by
/// X_MS it would not: it would have to be held. Such a turn is no rival, however well it fits.
bool LeavesItsRest(const RecognitionModel& model, const Pose& X_WM, const Pose& X_MS,
                   const Eigen::Vector3d& normal_W);

}  // namespace secondlook::perception
