#include "lib/fusion/pose_fusion.h"

#include <algorithm>
#include <utility>

#include <Eigen/Cholesky>

#include "lib/common/error.h"

namespace secondlook::fusion {

std::vector<int> LargestCluster(int count, const std::function<bool(int, int)>& same) {
  std::vector<int> largest;
  std::vector<char> taken(count, 0);
  for (int first = 0; first < count; ++first) {
    if (taken[first]) continue;
    taken[first] = 1;
    std::vector<int> cluster{first};
    for (std::size_t i = 0; i < cluster.size(); ++i) {
      for (int other = 0; other < count; ++other) {
        if (taken[other] || !same(cluster[i], other)) continue;
        taken[other] = 1;
        cluster.push_back(other);
      }
    }
    if (cluster.size() > largest.size()) largest = std::move(cluster);
  }
  std::sort(largest.begin(), largest.end());
  return largest;
}

FusedPose FusePoses(const std::vector<PoseEstimate>& estimates) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  if (estimates.empty()) throw InvalidArgument("there is no pose to fuse");
  // Weak enough to matter only where no view holds a direction.
  Matrix6 total = Matrix6::Zero();
  std::vector<Matrix6> information;
  for (const PoseEstimate& estimate : estimates) {
    if (!IsValid(estimate.X_WM) || !estimate.information.allFinite()) {
      throw InvalidArgument("a pose to be fused is not a rigid transform with finite information");
    }
    information.push_back(estimate.information +
                          Matrix6::Identity() / static_cast<double>(estimates.size()));
    total += information.back();
  }
  const Matrix6 covariance = total.ldlt().solve(Matrix6::Identity());
  Pose X_WM = estimates.front().X_WM;
  for (int round = 0; round < 20; ++round) {
    Vector6 gradient = Vector6::Zero();
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      const Pose& X = estimates[i].X_WM;
      const Eigen::AngleAxisd turn(X.linear() * X_WM.linear().transpose());
      Vector6 difference;
      difference << turn.angle() * turn.axis(), X.translation() - X_WM.translation();
      gradient += information[i] * difference;
    }
    const Vector6 step = covariance * gradient;
    X_WM.linear() = RotationFromVector(step.head<3>()) * X_WM.linear();
    X_WM.translation() += step.tail<3>();
    if (step.norm() < 1e-12) break;
  }
  X_WM.linear() = Eigen::Quaterniond(X_WM.linear()).normalized().toRotationMatrix();
  return {X_WM, covariance};
}

}  // namespace secondlook::fusion
