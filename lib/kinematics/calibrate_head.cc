#include "lib/kinematics/calibrate_head.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>

#include "lib/common/error.h"

namespace secondlook::kinematics {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kMinViews = 5;
constexpr double kMinSpread = 10.0 * kDegree;
constexpr double kMaxPixels = 2.0;
constexpr double kCornerSigma = 0.3;  // [px] of a corner that was found
constexpr int kIterations = 50;
constexpr int kShared = 12;  // parameters: rotation and translation of X_HC, then of X_H0P

/// What is estimated: poses, and a correction of each view's angles.
struct Estimate {
  Pose X_HC;
  Pose X_H0P;
  std::vector<HeadAngles> corrections;
};

Pose Moved(const Pose& X_AB, const Eigen::Matrix<double, 6, 1>& by) {
  Pose moved = X_AB;
  moved.linear() = RotationFromVector(by.head<3>()) * X_AB.linear();
  moved.translation() += by.tail<3>();
  return moved;
}

/// `estimate` after the step `x`: 12 values for both poses, then 2 for each view.
Estimate Moved(const Estimate& estimate, const Eigen::VectorXd& x) {
  Estimate moved{Moved(estimate.X_HC, x.head<6>()), Moved(estimate.X_H0P, x.segment<6>(6)),
                 estimate.corrections};
  for (std::size_t i = 0; i < moved.corrections.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(kShared + 2 * i);
    moved.corrections[i].pan += x[at];
    moved.corrections[i].tilt += x[at + 1];
  }
  return moved;
}

/// How far each corner of `view` is from where `estimate` has it [px]; x and y in turn.
Eigen::VectorXd Residuals(const BoardView& view, const HeadAngles& correction, const Pose& X_HC,
                          const Pose& X_H0P, const geometry::CameraModel& camera) {
  const HeadAngles head{view.head.pan + correction.pan, view.head.tilt + correction.tilt};
  const Pose X_CP = CameraInBase({Pose::Identity(), X_HC}, head).inverse() * X_H0P;
  Eigen::VectorXd residuals(2 * std::ssize(view.corners));
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    const Eigen::Vector3d p_CQ = X_CP * view.points_P[i];
    const Eigen::Vector2d seen(camera.fx * p_CQ.x() / p_CQ.z() + camera.cx,
                               camera.fy * p_CQ.y() / p_CQ.z() + camera.cy);
    residuals.segment<2>(static_cast<Eigen::Index>(2 * i)) = seen - view.corners[i];
  }
  return residuals;
}

/// The problem in normal form about an estimate: half the gradient, half the Hessian and the cost,
/// a corner counted by kCornerSigma.
struct NormalEquations {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
  double cost{};
};

class Problem {
 public:
  Problem(const std::vector<BoardView>& views, const geometry::CameraModel& camera,
          double encoder_sigma)
      : views_(views), camera_(camera), encoder_sigma_(encoder_sigma) {}

  double Cost(const Estimate& e) const {
    double cost = 0.0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      cost += At(e, i).squaredNorm() / Square(kCornerSigma) + Prior(e.corrections[i]);
    }
    return cost;
  }

  /// By forward differences.
  NormalEquations Linearise(const Estimate& e) const {
    const auto n = static_cast<Eigen::Index>(kShared + 2 * views_.size());
    NormalEquations normal{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), Cost(e)};
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const auto own = static_cast<Eigen::Index>(kShared + 2 * i);
      const Eigen::VectorXd r = At(e, i) / kCornerSigma;
      Eigen::MatrixXd jacobian(r.size(), kShared + 2);
      for (int k = 0; k < kShared + 2; ++k) {
        Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
        x[k < kShared ? k : own + k - kShared] = kStep;
        jacobian.col(k) = (At(Moved(e, x), i) / kCornerSigma - r) / kStep;
      }
      const Eigen::MatrixXd h = jacobian.transpose() * jacobian;
      const Eigen::VectorXd g = jacobian.transpose() * r;
      normal.hessian.topLeftCorner<kShared, kShared>() += h.topLeftCorner<kShared, kShared>();
      normal.hessian.block(0, own, kShared, 2) += h.topRightCorner(kShared, 2);
      normal.hessian.block(own, 0, 2, kShared) += h.bottomLeftCorner(2, kShared);
      normal.hessian.block<2, 2>(own, own) += h.bottomRightCorner<2, 2>();
      normal.gradient.head<kShared>() += g.head<kShared>();
      normal.gradient.segment<2>(own) += g.tail<2>();
      // The angles as the encoders say them are measurements, too.
      normal.hessian.diagonal().segment<2>(own).array() += 1.0 / Square(encoder_sigma_);
      normal.gradient[own] += e.corrections[i].pan / Square(encoder_sigma_);
      normal.gradient[own + 1] += e.corrections[i].tilt / Square(encoder_sigma_);
    }
    return normal;
  }

  /// Root mean square of all corners [px].
  double Pixels(const Estimate& e) const {
    double sum = 0.0;
    Eigen::Index count = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      sum += At(e, i).squaredNorm();
      count += std::ssize(views_[i].corners);
    }
    return std::sqrt(sum / static_cast<double>(std::max<Eigen::Index>(count, 1)));
  }

 private:
  static constexpr double kStep = 1e-6;

  static double Square(double x) { return x * x; }
  double Prior(const HeadAngles& c) const {
    return (Square(c.pan) + Square(c.tilt)) / Square(encoder_sigma_);
  }
  Eigen::VectorXd At(const Estimate& e, std::size_t i) const {
    return Residuals(views_[i], e.corrections[i], e.X_HC, e.X_H0P, camera_);
  }

  const std::vector<BoardView>& views_;
  const geometry::CameraModel& camera_;
  double encoder_sigma_;
};

/// Steps until nothing gets better.
Estimate Minimise(const Problem& problem, Estimate estimate) {
  double damping = 1e-3;
  for (int i = 0; i < kIterations && damping < 1e9; ++i) {
    const NormalEquations normal = problem.Linearise(estimate);
    Eigen::MatrixXd damped = normal.hessian;
    damped.diagonal() *= 1.0 + damping;
    const Estimate next = Moved(estimate, damped.ldlt().solve(-normal.gradient));
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

void RequireSpread(const std::vector<BoardView>& views) {
  if (views.size() < kMinViews) {
    Throw<InvalidArgument>(
        "the board was found in {} views, at least {} are needed: light it well, and let it fill a "
        "third of the image",
        views.size(), kMinViews);
  }
  const auto spread = [&](double HeadAngles::*angle) {
    const auto [least, most] = std::minmax_element(
        views.begin(), views.end(),
        [&](const auto& a, const auto& b) { return a.head.*angle < b.head.*angle; });
    return most->head.*angle - least->head.*angle;
  };
  const double pan = spread(&HeadAngles::pan);
  const double tilt = spread(&HeadAngles::tilt);
  if (pan < kMinSpread || tilt < kMinSpread) {
    Throw<InvalidArgument>(
        "the views of the board differ by {:.1f} deg of pan and {:.1f} deg of tilt, which does not "
        "tell where the camera sits; {:.0f} deg of both do: put the board farther away, so that it "
        "stays in view",
        pan / kDegree, tilt / kDegree, kMinSpread / kDegree);
  }
}

}  // namespace

Calibration CalibrateHead(const std::vector<BoardView>& views, const geometry::CameraModel& camera,
                          const HeadCalibration& nominal, double encoder_sigma) {
  RequireSpread(views);
  const Problem problem(views, camera, encoder_sigma);
  const Pose X_H0C = CameraInBase({Pose::Identity(), nominal.X_HC}, views.front().head);
  const Estimate estimate = Minimise(
      problem, {nominal.X_HC, X_H0C * views.front().X_CP, std::vector<HeadAngles>(views.size())});
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
  const double degrees = std::sqrt(covariance.diagonal().head<3>().maxCoeff()) / kDegree;
  const double metres = std::sqrt(covariance.diagonal().segment<3>(3).maxCoeff());
  return {{nominal.X_BH0, estimate.X_HC},
          {},
          CalibrationResiduals{static_cast<int>(views.size()), pixels, 1e3 * metres, degrees}};
}

}  // namespace secondlook::kinematics
