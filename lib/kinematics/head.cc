#include "lib/kinematics/head.h"

#include <cmath>

namespace secondlook::kinematics {

HeadCalibration HeadCalibration::AtHeight(double height) {
  HeadCalibration calibration;
  calibration.X_BH0.translation().z() = height;
  // Columns: C's right, down and forward axes in H (x forward, y left, z up).
  calibration.X_HC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return calibration;
}

Pose CameraInBase(const HeadCalibration& calibration, const HeadAngles& angles) {
  Pose X_H0H = Pose::Identity();
  X_H0H.linear() = RotationFromRollPitchYaw(0.0, angles.tilt, angles.pan);
  return calibration.X_BH0 * X_H0H * calibration.X_HC;
}

std::optional<HeadAngles> AimAt(const HeadCalibration& calibration, const Eigen::Vector3d& p_BQ) {
  const Eigen::Vector3d p_H0Q = calibration.X_BH0.inverse() * p_BQ;
  if (p_H0Q.head<2>().norm() < 0.05) return std::nullopt;
  HeadAngles angles{std::atan2(p_H0Q.y(), p_H0Q.x()),
                    std::atan2(-p_H0Q.z(), p_H0Q.head<2>().norm())};
  // The camera sits beside the head's origin and may be mounted askew, so the first guess is off by
  // what is then seen from the camera itself. Each round corrects by that; it contracts fast, as
  // the offsets are centimetres.
  for (int round = 0; round < 20; ++round) {
    const Eigen::Vector3d p_CQ = CameraInBase(calibration, angles).inverse() * p_BQ;
    if (p_CQ.norm() < 0.05) return std::nullopt;
    const double right = std::atan2(p_CQ.x(), p_CQ.z());
    const double down = std::atan2(p_CQ.y(), std::hypot(p_CQ.x(), p_CQ.z()));
    angles.pan = WrapAngle(angles.pan - right);
    angles.tilt += down;
    if (std::abs(right) + std::abs(down) < 1e-9) break;
  }
  return angles;
}

}  // namespace secondlook::kinematics
