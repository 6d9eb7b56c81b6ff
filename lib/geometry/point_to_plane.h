#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"

namespace secondlook::geometry {

/// A point that should lie on a plane. Both are in one frame A.
struct PointPlanePair {
  Eigen::Vector3d p_AP;      ///< The point that moves [m].
  Eigen::Vector3d p_AQ;      ///< A point of the plane [m].
  Eigen::Vector3d normal_A;  ///< Of the plane, unit.
  double weight{1.0};        ///< >= 0, e.g. 1 / variance of the distance [1/m^2].
};

/// One Gauss-Newton step that brings points onto their planes.
struct PointPlaneStep {
  /// Moves the points: p_AP becomes X * p_AP.
  Pose X{Pose::Identity()};
  /// J^T W J over (rotation about the points' centroid [rad], translation [m]), in A: the inverse
  /// covariance of the step when the weights are inverse variances.
  Eigen::Matrix<double, 6, 6> information{Eigen::Matrix<double, 6, 6>::Zero()};
  Eigen::Vector3d centroid_A{Eigen::Vector3d::Zero()};  ///< Weighted, of the points.
  /// How many of the 6 directions the pairs hold; along the others nothing was moved.
  int constrained{};
};

/// The step that minimises sum weight (normal . (X p - q))^2, linearised in the rotation.
/// Directions in which the pairs say too little are left alone rather than guessed (a plane slides
/// on a plane, a can turns about its axis): those whose eigenvalue of the information, rotation
/// scaled by the points' spread to metres, is below `min_constraint` of the total weight.
/// Fewer than 6 pairs of positive weight: no step, constrained = 0.
PointPlaneStep SolvePointToPlane(const std::vector<PointPlanePair>& pairs,
                                 double min_constraint = 0.005);

}  // namespace secondlook::geometry
