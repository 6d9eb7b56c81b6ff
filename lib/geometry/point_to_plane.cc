#include "lib/geometry/point_to_plane.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace secondlook::geometry {

PointPlaneStep SolvePointToPlane(const std::vector<PointPlanePair>& pairs, double min_constraint) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  PointPlaneStep step;
  double total = 0.0;
  int used = 0;
  for (const PointPlanePair& pair : pairs) {
    if (!(pair.weight > 0.0)) continue;
    step.centroid_A += pair.weight * pair.p_AP;
    total += pair.weight;
    ++used;
  }
  if (used < 6) return step;
  step.centroid_A /= total;

  double spread = 0.0;
  Vector6 gradient = Vector6::Zero();
  for (const PointPlanePair& pair : pairs) {
    if (!(pair.weight > 0.0)) continue;
    const Eigen::Vector3d arm = pair.p_AP - step.centroid_A;
    Vector6 jacobian;
    jacobian << arm.cross(pair.normal_A), pair.normal_A;
    const double residual = pair.normal_A.dot(pair.p_AQ - pair.p_AP);
    step.information += pair.weight * jacobian * jacobian.transpose();
    gradient += pair.weight * residual * jacobian;
    spread += pair.weight * arm.squaredNorm();
  }
  spread = std::sqrt(spread / total);
  if (!(spread > 0.0)) return step;

  // In metres throughout, so that the eigenvalues can be compared: a rotation counts by how far it
  // moves a point at the distance `spread`.
  Vector6 scale;
  scale << Eigen::Vector3d::Constant(1.0 / spread), Eigen::Vector3d::Ones();
  const Eigen::Matrix<double, 6, 6> scaled =
      scale.asDiagonal() * step.information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(scaled);
  Vector6 move = Vector6::Zero();
  const Vector6 scaled_gradient = scale.asDiagonal() * gradient;
  for (int i = 0; i < 6; ++i) {
    if (eigen.eigenvalues()[i] < min_constraint * total) continue;
    const Vector6 direction = eigen.eigenvectors().col(i);
    move += direction * (direction.dot(scaled_gradient) / eigen.eigenvalues()[i]);
    ++step.constrained;
  }
  move = scale.asDiagonal() * move;
  step.X.linear() = RotationFromVector(move.head<3>());
  step.X.translation() = step.centroid_A + move.tail<3>() - step.X.linear() * step.centroid_A;
  return step;
}

}  // namespace secondlook::geometry
