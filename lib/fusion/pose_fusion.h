#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"

namespace secondlook::fusion {

/// One view's estimate of a pose.
struct PoseEstimate {
  Pose X_WM{Pose::Identity()};
  /// Inverse covariance of (rotation vector [rad], translation [m]) in W, of the model's origin; a
  /// direction the view does not hold has zeros.
  Eigen::Matrix<double, 6, 6> information{Eigen::Matrix<double, 6, 6>::Identity()};
};

/// A fused pose.
struct FusedPose {
  Pose X_WM{Pose::Identity()};
  Eigen::Matrix<double, 6, 6> covariance{Eigen::Matrix<double, 6, 6>::Zero()};
};

/// When two estimates may be of one pose: both cut-offs must hold.
struct PoseCutOff {
  double max_m = 0.02;
  double max_rad = 0.17;
};

/// The members of the largest cluster of `count` estimates, ascending: nearest neighbours for which
/// `same(a, b)` holds belong together, and so on from neighbour to neighbour. Of two as large, the
/// one with the first estimate. Empty for count = 0.
std::vector<int> LargestCluster(int count, const std::function<bool(int, int)>& same);

/// The information-weighted mean of estimates of one pose (on SO(3) the Karcher mean). It does not
/// depend on their order. Estimates of a symmetric object must have been brought to the same one of
/// its equivalent poses; a direction that none holds keeps the plain mean, with a variance of 1.
/// @throws InvalidArgument when there is no estimate or one is not finite.
FusedPose FusePoses(const std::vector<PoseEstimate>& estimates);

}  // namespace secondlook::fusion
