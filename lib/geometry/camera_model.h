#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Core>

namespace secondlook::geometry {

/// Pinhole intrinsics of an undistorted image. (u, v) = (0, 0) is the *centre* of the top-left
/// pixel. Camera frame C: +x right, +y down, +z out of the lens.
struct CameraModel {
  int width{};        ///< Columns [px], > 0.
  int height{};       ///< Rows [px], > 0.
  double fx{}, fy{};  ///< Focal lengths [px], > 0.
  double cx{}, cy{};  ///< Principal point [px].

  /// Projects the point Q, given in C [m], to (u, v) [px]. Empty when Q is not in front of the
  /// camera or falls outside the image.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ) const {
    if (!(p_CQ.z() > 0.0)) return std::nullopt;
    const Eigen::Vector2d pixel(fx * p_CQ.x() / p_CQ.z() + cx, fy * p_CQ.y() / p_CQ.z() + cy);
    if (!(pixel.x() >= -0.5 && pixel.x() < width - 0.5)) return std::nullopt;
    if (!(pixel.y() >= -0.5 && pixel.y() < height - 0.5)) return std::nullopt;
    return pixel;
  }

  /// The direction (x, y, 1) in C of the ray through (u, v) [px]; times a depth z it is the point.
  Eigen::Vector3d Ray(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1.0}; }

  /// The model of the image scaled by `factor` > 0 (0.5: half as wide), same field of view.
  CameraModel Scaled(double factor) const {
    return {static_cast<int>(std::lround(width * factor)),
            static_cast<int>(std::lround(height * factor)),
            fx * factor,
            fy * factor,
            (cx + 0.5) * factor - 0.5,
            (cy + 0.5) * factor - 0.5};
  }

  /// @throws InvalidArgument naming the wrong value and `name`.
  void Validate(const char* name) const;

  friend bool operator==(const CameraModel&, const CameraModel&) = default;
};

}  // namespace secondlook::geometry
