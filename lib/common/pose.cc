#include "lib/common/pose.h"

#include <cmath>
#include <numbers>

namespace secondlook {

Pose ToPose(const Pose2& X_AB) {
  Pose X = Pose::Identity();
  X.translation() << X_AB.x, X_AB.y, 0.0;
  X.linear() = Eigen::AngleAxisd(X_AB.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return X;
}

Pose2 ToPose2(const Pose& X_AB) {
  const Eigen::Matrix3d R_AB = X_AB.linear();
  return {X_AB.translation().x(), X_AB.translation().y(), std::atan2(R_AB(1, 0), R_AB(0, 0))};
}

double WrapAngle(double angle) {
  constexpr double kPi = std::numbers::pi;
  const double wrapped = std::remainder(angle, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

Eigen::Matrix3d RotationFromRollPitchYaw(double roll, double pitch, double yaw) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
          AngleAxisd(roll, Vector3d::UnitX()))
      .toRotationMatrix();
}

double RotationDistance(const Eigen::Matrix3d& R_WA, const Eigen::Matrix3d& R_WB) {
  return Eigen::AngleAxisd(R_WA.transpose() * R_WB).angle();
}

Eigen::Matrix3d RotationFromVector(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

Pose LookAt(const Eigen::Vector3d& p_WC, const Eigen::Vector3d& p_WT) {
  const Eigen::Vector3d forward = (p_WT - p_WC).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Pose X_WC = Pose::Identity();
  X_WC.linear() << right, forward.cross(right), forward;
  X_WC.translation() = p_WC;
  return X_WC;
}

std::vector<Eigen::Vector3d> Transform(const Pose& X_AB,
                                       const std::vector<Eigen::Vector3d>& points_B) {
  std::vector<Eigen::Vector3d> points_A;
  points_A.reserve(points_B.size());
  for (const Eigen::Vector3d& p : points_B) points_A.push_back(X_AB * p);
  return points_A;
}

bool IsValid(const Pose& X_AB) {
  const Eigen::Matrix3d R = X_AB.linear();
  return X_AB.matrix().allFinite() &&
         (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6 &&
         R.determinant() > 0.0;
}

}  // namespace secondlook
