#include "lib/geometry/point_to_plane.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "lib/common/error.h"

namespace secondlook::geometry {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Takes (rotation, translation of Q) to (rotation, translation of O): t_O = t_Q + r x (o - q).
Matrix6 Lever(const Eigen::Vector3d& p_AQ, const Eigen::Vector3d& p_AO) {
  const Eigen::Vector3d arm = p_AO - p_AQ;
  Matrix6 lever = Matrix6::Identity();
  lever.bottomLeftCorner<3, 3>() << 0.0, arm.z(), -arm.y(),  //
      -arm.z(), 0.0, arm.x(),                                //
      arm.y(), -arm.x(), 0.0;
  return lever;
}

/// What the pairs say, in metres throughout, so that the eigenvalues can be compared: a rotation
/// counts by how far it moves a point at the distance `spread`.
struct Held {
  Vector6 scale{Vector6::Ones()};        ///< From scaled to true.
  Vector6 move{Vector6::Zero()};         ///< That the pairs ask for, scaled.
  Matrix6 information{Matrix6::Zero()};  ///< Scaled.
  Eigen::Vector3d centroid_A{Eigen::Vector3d::Zero()};
  int constrained{};
};

Held HeldBy(const std::vector<PointPlanePair>& pairs, double min_constraint) {
  Held held;
  double total = 0.0;
  int used = 0;
  for (const PointPlanePair& pair : pairs) {
    if (!(pair.weight > 0.0)) continue;
    held.centroid_A += pair.weight * pair.p_AP;
    total += pair.weight;
    ++used;
  }
  if (used < 6) {
    held.centroid_A.setZero();
    return held;
  }
  held.centroid_A /= total;

  double spread = 0.0;
  Matrix6 information = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  for (const PointPlanePair& pair : pairs) {
    if (!(pair.weight > 0.0)) continue;
    const Eigen::Vector3d arm = pair.p_AP - held.centroid_A;
    Vector6 jacobian;
    jacobian << arm.cross(pair.normal_A), pair.normal_A;
    const double residual = pair.normal_A.dot(pair.p_AQ - pair.p_AP);
    information += pair.weight * jacobian * jacobian.transpose();
    gradient += pair.weight * residual * jacobian;
    spread += pair.weight * arm.squaredNorm();
  }
  spread = std::sqrt(spread / total);
  if (!(spread > 0.0)) return held;

  held.scale << Eigen::Vector3d::Constant(1.0 / spread), Eigen::Vector3d::Ones();
  const Matrix6 scaled = held.scale.asDiagonal() * information * held.scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(scaled);
  const Vector6 scaled_gradient = held.scale.asDiagonal() * gradient;
  for (int i = 0; i < 6; ++i) {
    const double value = eigen.eigenvalues()[i];
    if (value < min_constraint * total) continue;
    const Vector6 direction = eigen.eigenvectors().col(i);
    held.move += direction * (direction.dot(scaled_gradient) / value);
    held.information += value * direction * direction.transpose();
    ++held.constrained;
  }
  return held;
}

/// Takes from the information what a shift of all pairs together by `sigma` leaves unknown: the
/// shift is one more unknown, marginalised.
void AllowShift(double sigma, Held* held) {
  if (!(sigma > 0.0)) return;
  const Eigen::Matrix<double, 6, 3> by_shift = held->information.rightCols<3>();
  const Eigen::Matrix3d shift =
      by_shift.bottomRows<3>() + Eigen::Matrix3d::Identity() / (sigma * sigma);
  held->information -= by_shift * shift.llt().solve(by_shift.transpose());
}

PointPlaneStep StepOf(const Held& held, const Vector6& scaled_move) {
  PointPlaneStep step;
  step.centroid_A = held.centroid_A;
  step.constrained = held.constrained;
  const Vector6 unscale = held.scale.cwiseInverse();
  step.information = unscale.asDiagonal() * held.information * unscale.asDiagonal();
  const Vector6 move = held.scale.asDiagonal() * scaled_move;
  step.X.linear() = RotationFromVector(move.head<3>());
  step.X.translation() = step.centroid_A + move.tail<3>() - step.X.linear() * step.centroid_A;
  return step;
}

}  // namespace

PointPlaneStep SolvePointToPlane(const std::vector<PointPlanePair>& pairs, double min_constraint) {
  const Held held = HeldBy(pairs, min_constraint);
  return StepOf(held, held.move);
}

PointPlaneStep SolvePointToPlane(const std::vector<PointPlanePair>& pairs, const MotionPrior& prior,
                                 double min_constraint) {
  Held held = HeldBy(pairs, min_constraint);
  AllowShift(prior.common_shift, &held);
  const Matrix6 to_prior = Lever(held.centroid_A, prior.p_AO) * held.scale.asDiagonal();
  const Matrix6 known = to_prior.transpose() * prior.information * to_prior;
  const Eigen::LLT<Matrix6> both(held.information + known);
  if (!known.allFinite() || known.llt().info() != Eigen::Success) {
    Throw<InvalidArgument>("point to plane: the information of the prior is not positive definite");
  }
  const Vector6 move = both.solve(held.information * held.move +
                                  to_prior.transpose() * prior.information * prior.mean);
  PointPlaneStep step = StepOf(held, move);
  const Vector6 off_pairs = move - held.move;
  const Vector6 off_prior = to_prior * move - prior.mean;
  step.sigmas = std::sqrt(off_pairs.dot(held.information * off_pairs) +
                          off_prior.dot(prior.information * off_prior));
  return step;
}

Matrix6 InformationAbout(const Eigen::Vector3d& p_AQ, const Eigen::Vector3d& p_AO,
                         const Matrix6& information) {
  const Matrix6 lever = Lever(p_AQ, p_AO);
  return lever.transpose() * information * lever;
}

}  // namespace secondlook::geometry
