#include "sim/arm_drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lib/common/error.h"

namespace secondlook::sim {
namespace {

constexpr double kErrorSettles = 0.1;   // [s] of moving until the error is another
constexpr double kOffsetSettles = 0.2;  // [s] until it is on the trajectory
constexpr double kDegrees = 180.0 / std::numbers::pi;

Pose ToPose(const Eigen::Matrix<double, 6, 1>& twist) {
  Pose X = Pose::Identity();
  X.translation() = twist.head<3>();
  X.linear() = RotationFromVector(twist.tail<3>());
  return X;
}

}  // namespace

ArmDrive::ArmDrive(const ArmSetup& setup, const NoiseConfig& noise, std::uint64_t seed)
    : setup_(setup),
      noise_(noise),
      rng_(ForkSeed(seed, "arm")),
      encoders_(setup.home),
      offset_(Eigen::VectorXd::Zero(setup.home.size())) {
  Rng mounting(ForkSeed(seed, "hand-eye"));
  X_EC_ = setup.hand.X_EC *
          ToPose(DrawTwist(noise.hand_eye_sigma, noise.hand_eye_sigma_deg, &mounting));
  error_ = DrawTwist(noise_.arm_sigma, noise_.arm_sigma_deg, &rng_);
  error_before_ = error_;
  error_after_ = error_;
}

ArmDrive::Vector6 ArmDrive::DrawTwist(double sigma, double sigma_deg, Rng* rng) {
  Vector6 twist;
  for (int i = 0; i < 6; ++i) twist[i] = rng->Gaussian(i < 3 ? sigma : sigma_deg / kDegrees);
  return twist;
}

void ArmDrive::Start(const hal::JointTrajectory& trajectory) {
  if (moves()) {
    Throw<InvalidArgument>("arm '{}' is moving; stop it before it gets another trajectory",
                           info().name);
  }
  hal::CheckTrajectory(trajectory, info().name, info().joints, encoders_);
  trajectory_ = trajectory;
  offset_ = encoders_ - trajectory.knots.front().q;
  clock_ = 0.0;
  elapsed_ = 0.0;
  rate_ = 1.0;
  brake_seconds_ = 0.0;
  status_ = {hal::MotionPhase::kMoving, ""};
  stop_requested_ = false;
  error_before_ = error_;
  error_after_ = DrawTwist(noise_.arm_sigma, noise_.arm_sigma_deg, &rng_);
  error_blend_ = 0.0;
}

void ArmDrive::Step(double dt) {
  if (!moves()) {
    stop_requested_ = false;
    return;
  }
  if (stop_requested_ && brake_seconds_ == 0.0) {
    // So long that no joint brakes harder than it may.
    const Eigen::VectorXd v = hal::Sample(trajectory_, clock_).v;
    brake_seconds_ = dt;
    for (int i = 0; i < v.size(); ++i) {
      brake_seconds_ = std::max(brake_seconds_, std::abs(v[i]) / info().joints[i].acceleration);
    }
  }
  if (brake_seconds_ > 0.0) rate_ = std::max(0.0, rate_ - dt / brake_seconds_);
  clock_ += rate_ * dt;
  elapsed_ += dt;
  error_blend_ = std::min(1.0, error_blend_ + dt / kErrorSettles);
  error_ = error_before_ + error_blend_ * (error_after_ - error_before_);
  const double off = offset_.isZero(0.0) ? 0.0 : std::max(0.0, 1.0 - elapsed_ / kOffsetSettles);
  encoders_ = hal::Sample(trajectory_, clock_).q + off * offset_;
  if (rate_ == 0.0) {
    End(hal::MotionPhase::kStopped);
  } else if (clock_ >= trajectory_.seconds() && off == 0.0) {
    End(hal::MotionPhase::kReached);
  }
}

Pose ArmDrive::TrueFlangeInBase() const { return chain().TipPose(encoders_) * ToPose(error_); }

Pose ArmDrive::TrueCameraInBase() const { return TrueFlangeInBase() * X_EC_; }

void ArmDrive::End(hal::MotionPhase phase) {
  status_ = {phase, ""};
  stop_requested_ = false;
}

}  // namespace secondlook::sim
