#pragma once

#include <atomic>
#include <cstddef>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/common/rng.h"
#include "lib/hal/base.h"
#include "sim/noise.h"
#include "sim/ramp.h"
#include "sim/surroundings.h"

namespace secondlook::sim {

/// The simulated base itself, behind SimBase: a differential drive that follows a path by what its
/// localisation says, and brakes for what its safety sensor truly sees ahead.
/// Threading: RequestStop() from any thread, the rest from the one that steps the world.
class BaseDrive {
 public:
  /// Stands at the true pose `X_WB`.
  BaseDrive(const Pose2& X_WB, const NoiseConfig& noise, std::uint64_t seed);

  static const hal::BaseInfo& Info();

  /// As hal::Base says. @throws InvalidArgument for a path it refuses.
  void Start(const hal::BasePath& path);
  void RequestStop() noexcept { stop_requested_ = true; }
  hal::MotionStatus Status() const { return status_; }

  /// Moves on by `dt` [s].
  void Step(double dt, const Surroundings& surroundings);

  /// Where it truly is.
  const Pose2& truth() const { return X_WB_; }
  /// Where localisation says that it is, at `time`.
  hal::BaseState Estimate(Time time) const;
  /// True when it neither drives nor turns.
  bool stands() const { return drive_.speed() == 0.0 && turn_.speed() == 0.0; }
  double speed() const { return drive_.speed(); }  ///< Along its heading [m/s].
  double metres() const { return metres_; }        ///< Driven since the start [m].

 private:
  enum class Leg { kBrake, kTurnToWaypoint, kStraight, kTurnToHeading };

  Pose2 EstimatedPose() const;
  void Move(double distance, double angle);
  void StepLocalisation(double dt);
  void StepLeg(double dt, const Surroundings& surroundings);
  void StepStraight(double dt, const Surroundings& surroundings);
  bool SeesSomethingAhead(double remaining, const Surroundings& surroundings);
  void NextWaypoint();
  void End(hal::MotionPhase phase, const std::string& reason);

  Pose2 X_WB_;          // the truth
  Pose2 error_;         // of localisation: estimate = truth + error
  Pose2 error_before_;  // at the start of the path
  Pose2 error_after_;   // what it will be at the next stop
  double error_blend_{1.0};
  Pose2 X_OB_;  // odometry
  double odometry_scale_{1.0};
  double odometry_turn_scale_{1.0};
  NoiseConfig noise_;
  Rng rng_;

  hal::BasePath path_;
  std::size_t waypoint_{};
  Leg leg_{Leg::kBrake};
  Ramp drive_;
  Ramp turn_;
  hal::MotionStatus status_;
  std::atomic<bool> stop_requested_{false};
  Eigen::Vector2d seen_W_{0.0, 0.0};  // what is in the way, truly
  double waited_{};                   // for it to go away [s]
  double path_metres_{};              // driven on this path
  double metres_{};
};

}  // namespace secondlook::sim
