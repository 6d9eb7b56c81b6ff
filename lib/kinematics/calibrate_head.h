#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/kinematics/calibration_file.h"
#include "lib/kinematics/head.h"

namespace secondlook::kinematics {

/// One look of the head's camera at a calibration board, whose frame is P.
struct BoardView {
  HeadAngles head;                        ///< By the encoders.
  std::vector<Eigen::Vector2d> corners;   ///< Where the board's corners are seen [px] …
  std::vector<Eigen::Vector3d> points_P;  ///< … and which these are [m].
  Pose X_CP{Pose::Identity()};            ///< The board in the camera, roughly.
};

/// Estimates X_HC, where the camera sits in the pan-tilt head, from views of a board that stands
/// still, taken by a base that stands still: the transform, the board's place and small corrections
/// of every view's angles that make the sum of squared residuals of all corners least
/// (Levenberg–Marquardt). X_BH0 is kept as in `nominal`: from one place nobody can tell it from the
/// board's.
/// @param encoder_sigma Of the angles [rad], > 0.
/// @throws InvalidArgument for fewer than 5 views, views that differ by less than 10 degrees of pan
/// or tilt, and residuals above 2 px, with what to do about it.
Calibration CalibrateHead(const std::vector<BoardView>& views, const geometry::CameraModel& camera,
                          const HeadCalibration& nominal, double encoder_sigma);

}  // namespace secondlook::kinematics
