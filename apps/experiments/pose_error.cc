#include "apps/experiments/pose_error.h"

#include <cmath>

#include "lib/common/rng.h"
#include "lib/geometry/sampling.h"

namespace secondlook::apps {
namespace {

constexpr int kPoints = 2000;
constexpr int kSurface = 60000;  // so dense that its spacing is no error

std::vector<Eigen::Vector3d> Sample(const geometry::Mesh& mesh, int count, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Eigen::Vector3d> points;
  for (const geometry::MeshSample& sample : geometry::SampleSurface(mesh, count, &rng)) {
    points.push_back(sample.surface.point.cast<double>());
  }
  return points;
}

}  // namespace

PoseErrorMetric::PoseErrorMetric(const geometry::Mesh& mesh)
    : points_M_(Sample(mesh, kPoints, 1)), surface_M_(Sample(mesh, kSurface, 2)) {}

PoseError PoseErrorMetric::Of(const Pose& X_CM_estimate, const Pose& X_CM_truth) const {
  const Pose X_estimate_truth = X_CM_estimate.inverse() * X_CM_truth;
  PoseError error;
  for (const Eigen::Vector3d& p : points_M_) {
    const Eigen::Vector3d q = X_estimate_truth * p;
    error.add += (q - p).norm();
    error.adds += std::sqrt(surface_M_.Nearest(q, 1).front().squared_distance);
  }
  error.add /= static_cast<double>(points_M_.size());
  error.adds /= static_cast<double>(points_M_.size());
  return error;
}

}  // namespace secondlook::apps
