#pragma once

#include <optional>

#include "lib/common/pose.h"

namespace secondlook::kinematics {

/// The fixed transforms of a camera on a pan-tilt head, from the calibration file.
struct HeadCalibration {
  /// The mount in the base: the frame of the head H when pan = tilt = 0 (x forward, z up).
  Pose X_BH0{Pose::Identity()};
  /// The camera C (x right, y down, z forward) in the head H.
  Pose X_HC{Pose::Identity()};

  /// A mount `height` [m] above B, straight above its origin, and a camera looking along H's x axis
  /// from H's origin.
  static HeadCalibration AtHeight(double height);
};

/// Pan and tilt [rad], as hal::PanTiltAngles defines them; kinematics does not see the HAL.
struct HeadAngles {
  double pan{};
  double tilt{};
};

/// X_BC when the head stands at `angles`: X_BH0 Rz(pan) Ry(tilt) X_HC.
Pose CameraInBase(const HeadCalibration& calibration, const HeadAngles& angles);

/// The angles that put the optical axis of the camera through the point Q, given in B [m]. Pan in
/// (-pi, pi], tilt in (-pi/2, pi/2). Empty when Q is nearer than 5 cm to the camera or the pan
/// axis, where no or every pan would do; limits are not checked.
std::optional<HeadAngles> AimAt(const HeadCalibration& calibration, const Eigen::Vector3d& p_BQ);

}  // namespace secondlook::kinematics
