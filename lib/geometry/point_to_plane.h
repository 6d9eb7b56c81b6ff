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

/// What is known beforehand of the motion that is sought, e.g. by a robot's kinematics.
struct MotionPrior {
  Eigen::Vector3d p_AO{Eigen::Vector3d::Zero()};  ///< A point O that moves along [m].
  /// The motion expected: (rotation vector [rad], translation of O [m]), in A.
  Eigen::Matrix<double, 6, 1> mean{Eigen::Matrix<double, 6, 1>::Zero()};
  /// Its inverse covariance, which counts beside the pairs' weights: these must be inverse
  /// variances, too.
  Eigen::Matrix<double, 6, 6> information{Eigen::Matrix<double, 6, 6>::Zero()};
  /// All pairs may be off together by this in each direction [m], however many they are: a sensor
  /// draws all edges inward.
  double common_shift{};
};

/// One Gauss-Newton step that brings points onto their planes.
struct PointPlaneStep {
  /// Moves the points: p_AP becomes X * p_AP.
  Pose X{Pose::Identity()};
  /// J^T W J over (rotation about the points' centroid [rad], translation [m]), in A, of the
  /// directions that the pairs hold: what they say of the motion, as an inverse covariance when the
  /// weights are inverse variances.
  Eigen::Matrix<double, 6, 6> information{Eigen::Matrix<double, 6, 6>::Zero()};
  Eigen::Vector3d centroid_A{Eigen::Vector3d::Zero()};  ///< Weighted, of the points.
  /// How many of the 6 directions the pairs hold; along the others nothing was moved, or as the
  /// prior expects.
  int constrained{};
  /// How far the pairs and the prior contradict each other: the Mahalanobis distance of their
  /// motions, by the covariances of both.
  double sigmas{};
};

/// The step that minimises sum weight (normal . (X p - q))^2, linearised in the rotation.
/// Directions in which the pairs say too little are left alone rather than guessed (a plane slides
/// on a plane, a can turns about its axis): those whose eigenvalue of the information, rotation
/// scaled by the points' spread to metres, is below `min_constraint` of the total weight.
/// Fewer than 6 pairs of positive weight: no step, constrained = 0.
PointPlaneStep SolvePointToPlane(const std::vector<PointPlanePair>& pairs,
                                 double min_constraint = 0.005);

/// The most probable step: that minimises the same sum and the squared Mahalanobis distance from
/// what `prior` expects. Directions that the pairs do not hold are left to the prior; in the others
/// the more certain of the two prevails. Fewer than 6 pairs of positive weight: the prior's mean.
/// @throws InvalidArgument when the prior's information is not positive definite.
PointPlaneStep SolvePointToPlane(const std::vector<PointPlanePair>& pairs, const MotionPrior& prior,
                                 double min_constraint = 0.005);

/// `information` of a motion as (rotation, translation of the point `p_AO`) for (rotation,
/// translation of the point `p_AQ`).
Eigen::Matrix<double, 6, 6> InformationAbout(const Eigen::Vector3d& p_AQ,
                                             const Eigen::Vector3d& p_AO,
                                             const Eigen::Matrix<double, 6, 6>& information);

}  // namespace secondlook::geometry
