#pragma once

#include <vector>

#include <Eigen/Geometry>

namespace secondlook {

/// A rigid transform; X_AB is the pose of frame B in frame A (docs/frames.md).
using Pose = Eigen::Isometry3d;

/// A pose on the floor: x, y [m] and the heading yaw [rad] about +z, in the frame its name says.
struct Pose2 {
  double x{};
  double y{};
  double yaw{};  ///< (-pi, pi] wherever this project writes it.

  friend bool operator==(const Pose2&, const Pose2&) = default;
};

/// The pose in space of a pose on the floor (z = 0, no roll or pitch).
Pose ToPose(const Pose2& X_AB);

/// The floor pose nearest to `X_AB`: its x, y and the heading of its x axis. @pre that axis is not
/// vertical.
Pose2 ToPose2(const Pose& X_AB);

/// `angle` [rad] brought into (-pi, pi].
double WrapAngle(double angle);

/// Rz(yaw) Ry(pitch) Rx(roll), all [rad].
Eigen::Matrix3d RotationFromRollPitchYaw(double roll, double pitch, double yaw);

/// The angle [rad], in [0, pi], of the rotation that takes `R_WA` to `R_WB`.
double RotationDistance(const Eigen::Matrix3d& R_WA, const Eigen::Matrix3d& R_WB);

/// The rotation of angle |v| [rad] about v (the exponential map of so(3)).
Eigen::Matrix3d RotationFromVector(const Eigen::Vector3d& v);

/// The pose X_WC of a camera (x right, y down, z forward) at `p_WC` that looks at `p_WT`, upright
/// in W, whose z is up. @pre the two are not above one another.
Pose LookAt(const Eigen::Vector3d& p_WC, const Eigen::Vector3d& p_WT);

/// The points `points_B` in A.
std::vector<Eigen::Vector3d> Transform(const Pose& X_AB,
                                       const std::vector<Eigen::Vector3d>& points_B);

/// True when every entry is finite and the rotation is orthonormal with determinant +1 within 1e-6.
bool IsValid(const Pose& X_AB);

}  // namespace secondlook
