#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/geometry/depth_rasteriser.h"

namespace secondlook::perception {

/// What a real depth camera and a real specimen add to the depth of one object: a smooth function
/// of the place, not noise. Structured light is off by a share of a percent that changes slowly
/// over the image (Khoshelham and Oude Elberink 2012, Accuracy and Resolution of Kinect Depth Data
/// for Indoor Mapping Applications), boxes bulge, and a pose is a little tilted. A polynomial of
/// second order in the place on the object. Its coefficients are held to zero by what is usual: so
/// a large object may be bent by millimetres, and a small one keeps its shape.
class DepthBias {
 public:
  /// Fits the bias to `difference` (measured minus rendered depth [m] by pixel of `window`, NaN =
  /// none), robustly: what differs by more than `gate` [m] is left out.
  /// @param inner By pixel, 0: not to be used.
  /// @param metres_per_pixel On the object.
  DepthBias(const std::vector<float>& difference, const std::vector<char>& inner,
            const geometry::PixelRect& window, double metres_per_pixel, double gate);

  /// The bias [m] at pixel (x, y) of the window.
  double At(int x, int y) const { return Terms(x, y).dot(coefficients_); }

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  Vector6 Terms(int x, int y) const;

  Eigen::Vector2d center_{Eigen::Vector2d::Zero()};  // [px]
  double scale_{};                                   // [m/px]
  Vector6 coefficients_{Vector6::Zero()};
};

}  // namespace secondlook::perception
