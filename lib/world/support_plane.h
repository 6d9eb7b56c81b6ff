#pragma once

#include <array>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/shape.h"

namespace secondlook::world {

/// A horizontal surface that things stand on, and its rectangle.
/// In which frame the values are is said by whoever holds one (A below).
struct SupportPlane {
  Eigen::Vector3d normal_A{0.0, 0.0, 1.0};  ///< Unit, against gravity.
  double offset{};                          ///< normal_A . p_AQ = offset for Q on the plane [m].
  std::array<Eigen::Vector3d, 4>
      corners_A;  ///< Of the fitted rectangle, counter-clockwise from above [m].
  int inliers{};  ///< Points it was fitted to.

  /// Height of the point above the plane [m].
  double HeightOf(const Eigen::Vector3d& p_AQ) const { return normal_A.dot(p_AQ) - offset; }

  /// True when the point's projection onto the plane lies in the rectangle grown by `margin` [m].
  bool Covers(const Eigen::Vector3d& p_AQ, double margin) const;
};

/// The same plane in frame W, given X_WA.
SupportPlane Transform(const Pose& X_WA, const SupportPlane& plane_A);

/// What a support surface stands on, as nobody sees its underside: a box from the floor to its top,
/// `margin` [m] larger than its rectangle on all sides. In W.
geometry::PlacedShape SolidBelow(const SupportPlane& plane_W, double margin);

}  // namespace secondlook::world
