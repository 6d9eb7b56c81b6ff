#pragma once

#include <atomic>
#include <optional>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/common/rng.h"
#include "lib/hal/arm.h"
#include "lib/kinematics/eye_in_hand.h"
#include "sim/noise.h"

namespace secondlook::sim {

/// A laser striper on the end-effector of an arm.
struct StriperSetup {
  Pose X_EL{Pose::Identity()};  ///< As calibrated.
  int held{};                   ///< Lines that wait at most to be taken.
};

/// What a simulated arm is: as its files say, before any error.
struct ArmSetup {
  hal::ArmInfo info;
  kinematics::EyeInHand hand;
  Eigen::VectorXd home;                   ///< Where it begins [rad].
  std::optional<StriperSetup> striper{};  ///< Empty: it carries none.
};

/// The simulated arm itself, behind SimArm. It follows a trajectory exactly by its encoders; its
/// flange is truly off by an error that changes with each motion, and the camera on it sits a
/// little beside where the calibration says, the same for a whole mission.
/// Threading: RequestStop() from any thread, the rest from the one that steps the world.
class ArmDrive {
 public:
  ArmDrive(const ArmSetup& setup, const NoiseConfig& noise, std::uint64_t seed);

  const hal::ArmInfo& info() const { return setup_.info; }
  const kinematics::Chain& chain() const { return setup_.hand.arm; }

  /// As hal::Arm says. @throws InvalidArgument for a trajectory it refuses.
  void Start(const hal::JointTrajectory& trajectory);
  void RequestStop() noexcept { stop_requested_ = true; }
  hal::MotionStatus Status() const { return status_; }

  /// Moves on by `dt` [s].
  void Step(double dt);

  /// What its encoders say [rad].
  const Eigen::VectorXd& encoders() const { return encoders_; }
  bool moves() const { return status_.phase == hal::MotionPhase::kMoving; }
  /// X_BE as it truly is.
  Pose TrueFlangeInBase() const;
  /// Where its camera truly is, in the base.
  Pose TrueCameraInBase() const;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  /// Translation [m] and rotation [rad], each axis normal.
  static Vector6 DrawTwist(double sigma, double sigma_deg, Rng* rng);
  void End(hal::MotionPhase phase);

  ArmSetup setup_;
  NoiseConfig noise_;
  Rng rng_;
  Pose X_EC_;  // true
  Eigen::VectorXd encoders_;
  Vector6 error_;  // of E, in E
  Vector6 error_before_;
  Vector6 error_after_;
  double error_blend_{1.0};

  hal::JointTrajectory trajectory_;
  Eigen::VectorXd offset_;  // from the trajectory to where it was when it began
  double clock_{};          // how far along the trajectory [s]
  double elapsed_{};        // since it began [s]
  double rate_{1.0};        // of that clock; below 1 when it brakes
  double brake_seconds_{};  // that braking takes; 0: it does not brake
  hal::MotionStatus status_;
  std::atomic<bool> stop_requested_{false};
};

}  // namespace secondlook::sim
