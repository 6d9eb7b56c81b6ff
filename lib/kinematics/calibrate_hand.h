#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/kinematics/calibration_file.h"
#include "lib/kinematics/carried_camera.h"
#include "lib/kinematics/chain.h"

namespace secondlook::kinematics {

/// One look of the camera in an arm's hand at a calibration board.
struct HandView {
  Eigen::VectorXd q;  ///< Joint angles by the encoders [rad].
  SightedBoard board;
};

/// How exactly an arm says where its end-effector is: standard deviations along and about each
/// axis.
struct ArmErrors {
  double metres{0.001};
  double radians{0.00175};
};

/// Where a camera sits in the hand.
struct HandCalibration {
  Pose X_EC{Pose::Identity()};
  CalibrationResiduals residuals;
};

/// Estimates X_EC, the hand–eye calibration, from views of a board that stands still, taken by an
/// arm whose base stands still: in closed form (F. C. Park and B. J. Martin, "Robot sensor
/// calibration: solving AX = XB on the Euclidean group", IEEE Transactions on Robotics and
/// Automation 10, 1994; OpenCV), then refined over all corners of all views
/// (CalibrateCarriedCamera()). No nominal place is needed.
/// @throws InvalidArgument for fewer than 8 views, views that do not turn the hand about two axes,
/// and residuals above 2 px, with what to do about it.
HandCalibration CalibrateHand(const std::vector<HandView>& views,
                              const geometry::CameraModel& camera, const Chain& arm,
                              const ArmErrors& errors = {});

}  // namespace secondlook::kinematics
