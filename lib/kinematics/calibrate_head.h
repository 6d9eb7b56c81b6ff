#pragma once

#include <vector>

#include "lib/geometry/camera_model.h"
#include "lib/kinematics/calibration_file.h"
#include "lib/kinematics/carried_camera.h"
#include "lib/kinematics/head.h"

namespace secondlook::kinematics {

/// One look of the head's camera at a calibration board.
struct BoardView {
  HeadAngles head;  ///< By the encoders.
  SightedBoard board;
};

/// Estimates X_HC, where the camera sits in the pan-tilt head, from views of a board that stands
/// still, taken by a base that stands still, with small corrections of every view's angles
/// (CalibrateCarriedCamera()). X_BH0 is kept as in `nominal`: from one place nobody can tell it
/// from the board's.
/// @param encoder_sigma Of the angles [rad], > 0.
/// @throws InvalidArgument for fewer than 5 views, views that differ by less than 10 degrees of pan
/// or tilt, and residuals above 2 px, with what to do about it.
Calibration CalibrateHead(const std::vector<BoardView>& views, const geometry::CameraModel& camera,
                          const HeadCalibration& nominal, double encoder_sigma);

}  // namespace secondlook::kinematics
