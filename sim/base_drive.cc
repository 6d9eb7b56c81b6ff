#include "sim/base_drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "lib/common/error.h"

namespace secondlook::sim {
namespace {

using Eigen::Vector2d;

constexpr RampLimits kDrive{0.5, 0.5};        // [m/s], [m/s^2]
constexpr RampLimits kTurn{1.0, 2.0};         // [rad/s], [rad/s^2]
constexpr double kAtWaypoint = 0.005;         // [m]
constexpr double kClearance = 0.02;           // [m] that the safety sensor keeps
constexpr double kLookAhead = 0.3;            // [m] beyond the stopping distance
constexpr double kBerth = 0.3;                // [m] that it keeps from what moves, besides
constexpr double kPatience = 4.0;             // [s] for what is in the way to pass
constexpr double kLocalisationSettles = 1.0;  // [s] of moving until its error is another
constexpr double kSteerUntil = 0.2;           // [m] before the waypoint it stops correcting
constexpr double kSteerGain = 1.5;            // [1/s]
constexpr double kRadians = std::numbers::pi / 180.0;

Vector2d Position(const Pose2& pose) { return {pose.x, pose.y}; }

Vector2d Heading(double yaw) { return {std::cos(yaw), std::sin(yaw)}; }

double DirectionTo(const Pose2& from, const Pose2& to) {
  return std::atan2(to.y - from.y, to.x - from.x);
}

}  // namespace

BaseDrive::BaseDrive(const Pose2& X_WB, const NoiseConfig& noise, std::uint64_t seed)
    : X_WB_(X_WB), noise_(noise), rng_(ForkSeed(seed, "base")) {
  odometry_scale_ += rng_.Gaussian(noise.odometry_drift);
  odometry_turn_scale_ += rng_.Gaussian(noise.odometry_drift);
  const double yaw_sigma = noise.localisation_sigma_deg * kRadians;
  error_ = {rng_.Gaussian(noise.localisation_sigma), rng_.Gaussian(noise.localisation_sigma),
            rng_.Gaussian(yaw_sigma)};
  error_before_ = error_;
  error_after_ = error_;
}

const hal::BaseInfo& BaseDrive::Info() {
  static const hal::BaseInfo info{"base", 0.28, 1.3, kDrive.speed, kTurn.speed};
  return info;
}

void BaseDrive::Start(const hal::BasePath& path) {
  if (path.waypoints_W.empty()) {
    Throw<InvalidArgument>("base '{}': the path has no waypoint", Info().name);
  }
  for (std::size_t i = 0; i < path.waypoints_W.size(); ++i) {
    const Pose2& w = path.waypoints_W[i];
    if (std::isfinite(w.x) && std::isfinite(w.y) && std::isfinite(w.yaw)) continue;
    Throw<InvalidArgument>("base '{}': waypoint {} of the path, ({}, {}, {}), is not finite",
                           Info().name, i, w.x, w.y, w.yaw);
  }
  path_ = path;
  waypoint_ = 0;
  leg_ = Leg::kBrake;
  status_ = {hal::MotionPhase::kMoving, ""};
  stop_requested_ = false;
  waited_ = 0.0;
  path_metres_ = 0.0;
  error_before_ = error_;
  error_after_ = {rng_.Gaussian(noise_.localisation_sigma),
                  rng_.Gaussian(noise_.localisation_sigma),
                  rng_.Gaussian(noise_.localisation_sigma_deg * kRadians)};
  error_blend_ = 0.0;
}

Pose2 BaseDrive::EstimatedPose() const {
  return {X_WB_.x + error_.x, X_WB_.y + error_.y, WrapAngle(X_WB_.yaw + error_.yaw)};
}

hal::BaseState BaseDrive::Estimate(Time time) const {
  hal::BaseState state{time, EstimatedPose(), X_OB_, Eigen::Matrix3d::Zero()};
  const double yaw_sigma = noise_.localisation_sigma_deg * kRadians;
  state.covariance_WB.diagonal() << noise_.localisation_sigma * noise_.localisation_sigma,
      noise_.localisation_sigma * noise_.localisation_sigma, yaw_sigma * yaw_sigma;
  return state;
}

void BaseDrive::Move(double distance, double angle) {
  // Along the chord of the arc.
  const Vector2d way_W = distance * Heading(X_WB_.yaw + angle / 2);
  X_WB_ = {X_WB_.x + way_W.x(), X_WB_.y + way_W.y(), WrapAngle(X_WB_.yaw + angle)};
  const double measured_angle = angle * odometry_turn_scale_;
  const Vector2d way_O = distance * odometry_scale_ * Heading(X_OB_.yaw + measured_angle / 2);
  X_OB_ = {X_OB_.x + way_O.x(), X_OB_.y + way_O.y(), WrapAngle(X_OB_.yaw + measured_angle)};
  path_metres_ += std::abs(distance);
  metres_ += std::abs(distance);
}

void BaseDrive::StepLocalisation(double dt) {
  if (stands()) return;
  error_blend_ = std::min(1.0, error_blend_ + dt / kLocalisationSettles);
  const auto mix = [&](double before, double after) {
    return before + error_blend_ * (after - before);
  };
  error_ = {mix(error_before_.x, error_after_.x), mix(error_before_.y, error_after_.y),
            mix(error_before_.yaw, error_after_.yaw)};
}

void BaseDrive::Step(double dt, const Surroundings& surroundings) {
  if (status_.phase != hal::MotionPhase::kMoving) {
    stop_requested_ = false;
    return;
  }
  if (stop_requested_) {
    Move(drive_.Brake(kDrive, dt), turn_.Brake(kTurn, dt));
    if (stands()) End(hal::MotionPhase::kStopped, "");
  } else {
    StepLeg(dt, surroundings);
  }
  StepLocalisation(dt);
}

void BaseDrive::StepLeg(double dt, const Surroundings& surroundings) {
  const Pose2 estimate = EstimatedPose();
  const Pose2& waypoint = path_.waypoints_W[waypoint_];
  switch (leg_) {
    case Leg::kBrake:
      Move(drive_.Brake(kDrive, dt), turn_.Brake(kTurn, dt));
      if (stands()) leg_ = Leg::kTurnToWaypoint;
      return;
    case Leg::kTurnToWaypoint: {
      if ((Position(waypoint) - Position(estimate)).norm() < kAtWaypoint) return NextWaypoint();
      const double left = WrapAngle(DirectionTo(estimate, waypoint) - estimate.yaw);
      Move(0.0, turn_.Approach(left, kTurn, dt));
      if (stands()) leg_ = Leg::kStraight;
      return;
    }
    case Leg::kStraight:
      return StepStraight(dt, surroundings);
    case Leg::kTurnToHeading: {
      const double left = WrapAngle(waypoint.yaw - estimate.yaw);
      Move(0.0, turn_.Approach(left, kTurn, dt));
      if (stands()) End(hal::MotionPhase::kReached, "");
      return;
    }
  }
}

void BaseDrive::StepStraight(double dt, const Surroundings& surroundings) {
  const Pose2 estimate = EstimatedPose();
  const Vector2d way = Position(path_.waypoints_W[waypoint_]) - Position(estimate);
  const double remaining = way.dot(Heading(estimate.yaw));
  if (remaining <= 0.0 && drive_.speed() == 0.0) return NextWaypoint();
  if (SeesSomethingAhead(std::max(remaining, 0.0), surroundings)) {
    Move(drive_.Brake(kDrive, dt), turn_.Brake(kTurn, dt));
    if (!stands()) return;
    waited_ += dt;
    if (waited_ < kPatience) return;
    const Vector2d seen_W = seen_W_ + Vector2d(error_.x, error_.y);
    return End(hal::MotionPhase::kFailed,
               fmt::format("base '{}': blocked after {:.2f} m by something at ({:.2f}, {:.2f}) in "
                           "W that did not move away within {:.0f} s",
                           Info().name, path_metres_, seen_W.x(), seen_W.y(), kPatience));
  }
  waited_ = 0.0;
  double steer = 0.0;
  if (remaining > kSteerUntil) {
    const double off = WrapAngle(std::atan2(way.y(), way.x()) - estimate.yaw);
    steer = std::clamp(kSteerGain * off, -kTurn.speed, kTurn.speed) * dt;
  }
  Move(drive_.Approach(remaining, kDrive, dt), steer);
  if (drive_.speed() == 0.0) NextWaypoint();
}

bool BaseDrive::SeesSomethingAhead(double remaining, const Surroundings& surroundings) {
  const double stopping = drive_.speed() * drive_.speed() / (2.0 * kDrive.acceleration);
  const double reach = Info().radius + kClearance;
  const Vector2d here = Position(X_WB_);
  const Vector2d there =
      here + std::min(stopping + kLookAhead, remaining + kAtWaypoint) * Heading(X_WB_.yaw);
  const std::optional<Vector2d> seen = surroundings.InTheWay(here, there, reach, kBerth);
  if (seen) seen_W_ = *seen;
  return seen.has_value();
}

void BaseDrive::NextWaypoint() {
  if (waypoint_ + 1 == path_.waypoints_W.size()) {
    leg_ = Leg::kTurnToHeading;
    return;
  }
  ++waypoint_;
  leg_ = Leg::kTurnToWaypoint;
}

void BaseDrive::End(hal::MotionPhase phase, const std::string& reason) {
  status_ = {phase, reason};
  stop_requested_ = false;
}

}  // namespace secondlook::sim
