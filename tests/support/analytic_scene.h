#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/hal/base.h"
#include "lib/world/support_plane.h"

namespace secondlook::testing {

/// A box centred at A.
struct SolidBox {
  Pose X_WA;
  Eigen::Vector3d size;
};

/// An upright cylinder.
struct SolidCylinder {
  Eigen::Vector3d p_WBottom;
  double radius;
  double height;
};

/// Solids above the floor z = 0.
struct AnalyticScene {
  std::vector<SolidBox> boxes;
  std::vector<SolidCylinder> cylinders;
  bool floor{true};

  /// How far along `direction_W` the first surface is, in lengths of it; infinity: none.
  double Cast(const Eigen::Vector3d& from_W, const Eigen::Vector3d& direction_W) const {
    double nearest = std::numeric_limits<double>::infinity();
    if (floor && direction_W.z() < 0.0) nearest = -from_W.z() / direction_W.z();
    for (const SolidBox& box : boxes) {
      const Eigen::Array3d o = (box.X_WA.inverse() * from_W).array();
      const Eigen::Array3d d = (box.X_WA.linear().transpose() * direction_W).array();
      const Eigen::Array3d a = (-0.5 * box.size.array() - o) / d;
      const Eigen::Array3d b = (0.5 * box.size.array() - o) / d;
      const double enter = a.min(b).maxCoeff();
      if (enter > 0.0 && enter < a.max(b).minCoeff()) nearest = std::min(nearest, enter);
    }
    for (const SolidCylinder& cylinder : cylinders) {
      nearest = std::min(nearest, CastCylinder(cylinder, from_W, direction_W));
    }
    return nearest;
  }

  /// The depth image z_C [m] that an ideal camera sees; NaN where there is nothing.
  cv::Mat Render(const geometry::CameraModel& camera, const Pose& X_WC) const {
    cv::Mat depth(camera.height, camera.width, CV_32FC1);
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const double z = Cast(X_WC.translation(), X_WC.linear() * camera.Ray(u, v));
        depth.at<float>(v, u) =
            std::isinf(z) ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(z);
      }
    }
    return depth;
  }

 private:
  static double CastCylinder(const SolidCylinder& cylinder, const Eigen::Vector3d& from_W,
                             const Eigen::Vector3d& d) {
    double nearest = std::numeric_limits<double>::infinity();
    const Eigen::Vector3d o = from_W - cylinder.p_WBottom;
    const double top = (cylinder.height - o.z()) / d.z();
    if (top > 0.0 && (o + top * d).head<2>().norm() <= cylinder.radius) nearest = top;
    const double a = d.head<2>().squaredNorm();
    const double b = o.head<2>().dot(d.head<2>());
    const double c = o.head<2>().squaredNorm() - cylinder.radius * cylinder.radius;
    if (b * b - a * c > 0.0) {
      const double t = (-b - std::sqrt(b * b - a * c)) / a;
      const double z = o.z() + t * d.z();
      if (t > 0.0 && z >= 0.0 && z <= cylinder.height) nearest = std::min(nearest, t);
    }
    return nearest;
  }
};

/// The pose of a camera at `p_WC` that looks at `p_WQ`, image-up against gravity.
inline Pose LookingAt(const Eigen::Vector3d& p_WC, const Eigen::Vector3d& p_WQ) {
  Pose X_WC = Pose::Identity();
  const Eigen::Vector3d forward = (p_WQ - p_WC).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  X_WC.linear() << right, forward.cross(right), forward;
  X_WC.translation() = p_WC;
  return X_WC;
}

/// The rectangle of `size` around `center_W`, turned by `yaw`.
inline world::SupportPlane MakeSupport(const Eigen::Vector3d& center_W, const Eigen::Vector2d& size,
                                       double yaw = 0.0) {
  world::SupportPlane plane_W;
  plane_W.offset = center_W.z();
  const Eigen::Matrix3d R = RotationFromRollPitchYaw(0.0, 0.0, yaw);
  const double x = 0.5 * size.x();
  const double y = 0.5 * size.y();
  plane_W.corners_A = {
      center_W + R * Eigen::Vector3d(-x, -y, 0), center_W + R * Eigen::Vector3d(x, -y, 0),
      center_W + R * Eigen::Vector3d(x, y, 0), center_W + R * Eigen::Vector3d(-x, y, 0)};
  return plane_W;
}

/// A round base as large as a usual one.
inline hal::BaseInfo MakeBase() { return {"base", 0.25, 1.3, 0.5, 1.0}; }

}  // namespace secondlook::testing
