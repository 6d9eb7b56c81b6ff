#include "lib/kinematics/carried_camera.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "lib/common/error.h"

namespace secondlook::kinematics {
namespace {

constexpr double kMaxPixels = 2.0;
constexpr double kCornerSigma = 0.3;  // [px] of a corner that was found
constexpr int kIterations = 50;
constexpr double kStep = 1e-6;  // of forward differences
constexpr int kShared = 12;     // parameters: rotation and translation of X_EC, then of X_BP

using Eigen::Index;
using Eigen::VectorXd;

/// What is estimated: poses, and a correction of each view.
struct Estimate {
  Pose X_EC;
  Pose X_BP;
  std::vector<VectorXd> corrections;
};

Pose Moved(const Pose& X_AB, const Eigen::Matrix<double, 6, 1>& by) {
  Pose moved = X_AB;
  moved.linear() = RotationFromVector(by.head<3>()) * X_AB.linear();
  moved.translation() += by.tail<3>();
  return moved;
}

/// How far each corner of `view` is from where it should be [px]; x and y in turn.
VectorXd Residuals(const CarriedView& view, const Pose& X_EC, const Pose& X_BP,
                   const VectorXd& correction, const geometry::CameraModel& camera) {
  const Pose X_CP = (view.X_BE(correction) * X_EC).inverse() * X_BP;
  const SightedBoard& board = view.board;
  VectorXd residuals(2 * std::ssize(board.corners));
  for (std::size_t i = 0; i < board.corners.size(); ++i) {
    const Eigen::Vector3d p_CQ = X_CP * board.points_P[i];
    const Eigen::Vector2d seen(camera.fx * p_CQ.x() / p_CQ.z() + camera.cx,
                               camera.fy * p_CQ.y() / p_CQ.z() + camera.cy);
    residuals.segment<2>(static_cast<Index>(2 * i)) = seen - board.corners[i];
  }
  return residuals;
}

/// The problem in normal form about an estimate: half the gradient, half the Hessian and the cost,
/// a corner counted by kCornerSigma.
struct NormalEquations {
  Eigen::MatrixXd hessian;
  VectorXd gradient;
  double cost{};
};

class Problem {
 public:
  Problem(const std::vector<CarriedView>& views, const geometry::CameraModel& camera,
          const VectorXd& sigmas)
      : views_(views), camera_(camera), weights_(sigmas.cwiseAbs2().cwiseInverse()) {}

  double Cost(const Estimate& e) const {
    double cost = 0.0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      cost += At(e, i).squaredNorm() / (kCornerSigma * kCornerSigma) +
              e.corrections[i].cwiseAbs2().dot(weights_);
    }
    return cost;
  }

  NormalEquations Linearise(const Estimate& e) const {
    const Index k = weights_.size();
    const Index n = kShared + k * std::ssize(views_);
    NormalEquations normal{Eigen::MatrixXd::Zero(n, n), VectorXd::Zero(n), Cost(e)};
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const Index own = kShared + k * static_cast<Index>(i);
      const VectorXd r = At(e, i) / kCornerSigma;
      const Eigen::MatrixXd jacobian = Jacobian(e, i, r);
      const Eigen::MatrixXd h = jacobian.transpose() * jacobian;
      const VectorXd g = jacobian.transpose() * r;
      normal.hessian.topLeftCorner<kShared, kShared>() += h.topLeftCorner<kShared, kShared>();
      normal.hessian.block(0, own, kShared, k) += h.topRightCorner(kShared, k);
      normal.hessian.block(own, 0, k, kShared) += h.bottomLeftCorner(k, kShared);
      normal.hessian.block(own, own, k, k) += h.bottomRightCorner(k, k);
      normal.gradient.head<kShared>() += g.head<kShared>();
      normal.gradient.segment(own, k) += g.tail(k);
      // What the robot says of itself is a measurement, too.
      normal.hessian.diagonal().segment(own, k) += weights_;
      normal.gradient.segment(own, k) += e.corrections[i].cwiseProduct(weights_);
    }
    return normal;
  }

  /// `e` after the step `x`: 12 values for both poses, then those of each view.
  Estimate After(const Estimate& e, const VectorXd& x) const {
    Estimate after{Moved(e.X_EC, x.head<6>()), Moved(e.X_BP, x.segment<6>(6)), e.corrections};
    const Index k = weights_.size();
    for (std::size_t i = 0; i < after.corrections.size(); ++i) {
      after.corrections[i] += x.segment(kShared + k * static_cast<Index>(i), k);
    }
    return after;
  }

  /// Root mean square of all corners [px].
  double Pixels(const Estimate& e) const {
    double sum = 0.0;
    std::ptrdiff_t count = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      sum += At(e, i).squaredNorm();
      count += std::ssize(views_[i].board.corners);
    }
    return std::sqrt(sum / static_cast<double>(std::max<std::ptrdiff_t>(count, 1)));
  }

 private:
  VectorXd At(const Estimate& e, std::size_t i) const {
    return Residuals(views_[i], e.X_EC, e.X_BP, e.corrections[i], camera_);
  }

  /// Of the residuals `r` of a view, by forward differences.
  Eigen::MatrixXd Jacobian(const Estimate& e, std::size_t i, const VectorXd& r) const {
    const Index k = weights_.size();
    Eigen::MatrixXd jacobian(r.size(), kShared + k);
    for (Index c = 0; c < kShared + k; ++c) {
      VectorXd x = VectorXd::Zero(kShared + k);
      x[c] = kStep;
      const VectorXd moved =
          Residuals(views_[i], Moved(e.X_EC, x.head<6>()), Moved(e.X_BP, x.segment<6>(6)),
                    e.corrections[i] + x.tail(k), camera_);
      jacobian.col(c) = (moved / kCornerSigma - r) / kStep;
    }
    return jacobian;
  }

  const std::vector<CarriedView>& views_;
  const geometry::CameraModel& camera_;
  VectorXd weights_;
};

/// Steps until nothing gets better.
Estimate Minimise(const Problem& problem, Estimate estimate) {
  double damping = 1e-3;
  for (int i = 0; i < kIterations && damping < 1e9; ++i) {
    const NormalEquations normal = problem.Linearise(estimate);
    Eigen::MatrixXd damped = normal.hessian;
    damped.diagonal() *= 1.0 + damping;
    const Estimate next = problem.After(estimate, damped.ldlt().solve(-normal.gradient));
    const double cost = problem.Cost(next);
    if (!(cost < normal.cost)) {
      damping *= 10.0;
      continue;
    }
    estimate = next;
    damping = std::max(0.1 * damping, 1e-9);
    if (normal.cost - cost < 1e-9 * normal.cost) break;
  }
  return estimate;
}

}  // namespace

CarriedCamera CalibrateCarriedCamera(const std::vector<CarriedView>& views,
                                     const geometry::CameraModel& camera,
                                     const CarriedCamera& start, const Eigen::VectorXd& sigmas) {
  const Problem problem(views, camera, sigmas);
  const Estimate estimate = Minimise(
      problem,
      {start.X_EC, start.X_BP, std::vector<VectorXd>(views.size(), VectorXd::Zero(sigmas.size()))});
  const double pixels = problem.Pixels(estimate);
  if (!(pixels <= kMaxPixels)) {
    Throw<InvalidArgument>(
        "the corners are {:.1f} px from where any place of the camera puts them: are the camera's "
        "intrinsics and the size of the board's squares right, and did the board and the base "
        "stand still?",
        pixels);
  }
  const NormalEquations normal = problem.Linearise(estimate);
  const Eigen::MatrixXd covariance = normal.hessian.ldlt().solve(
      Eigen::MatrixXd::Identity(normal.hessian.rows(), normal.hessian.cols()));
  const VectorXd variance = covariance.diagonal();
  return {estimate.X_EC, estimate.X_BP, pixels, std::sqrt(variance.segment<3>(3).maxCoeff()),
          std::sqrt(variance.head<3>().maxCoeff())};
}

}  // namespace secondlook::kinematics
