#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/hal/laser_striper.h"
#include "lib/kinematics/inverse_kinematics.h"
#include "lib/planning/motion/plan_motion.h"

namespace secondlook::planning {

struct SweepConfig {
  double speed_m_s{0.04};    ///< Of the laser: at 50 lines a second they are 0.8 mm apart.
  double max_length_m{0.3};  ///< Of one sweep.
  double max_seconds{10.0};  ///< Likewise.
  double run_up_s{0.2};      ///< From rest to that speed, and again to rest.
  double exact_m{0.0003};    ///< The laser leaves its straight line by no more than this …
  double exact_deg{0.05};    ///< … and this.
  kinematics::InverseKinematicsConfig inverse_kinematics;
  MotionConfig motion;  ///< On the way to where it begins.

  template <class A>
  void Serialize(A* a) {
    a->Visit("speed_m_s", &speed_m_s);
    a->Visit("max_length_m", &max_length_m);
    a->Visit("max_seconds", &max_seconds);
    a->Visit("run_up_s", &run_up_s);
    a->Visit("exact_m", &exact_m);
    a->Visit("exact_deg", &exact_deg);
    a->Visit("inverse_kinematics", &inverse_kinematics);
    a->Visit("motion", &motion);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A scan: the laser (frame L, hal::StriperInfo) goes straight along y_L, from `length_m` / 2
/// before its middle to as far behind it, without turning. Its line lies across that, so the scan
/// is as broad as the fan. Which end comes first, and which way x_L points, makes no difference to
/// it.
struct SweepGoal {
  Pose X_WL{Pose::Identity()};  ///< Of the laser in the middle of the sweep.
  double length_m{};
};

/// The scan across `p_WT` whose light falls along `direction_W`, from the middle of the striper's
/// range, and which moves as much along `across_W` as it can.
/// @throws InvalidArgument when the two are parallel or not finite.
SweepGoal SweepOver(const Eigen::Vector3d& p_WT, const Eigen::Vector3d& direction_W,
                    const Eigen::Vector3d& across_W, double length_m,
                    const hal::StriperInfo& striper);

/// What came of planning a sweep, from the worst to the best.
enum class SweepOutcome {
  kTooLong,      ///< Beyond max_length_m or max_seconds.
  kUnreachable,  ///< Where it begins no joint angles bring the laser, whichever end that is.
  kOffTheLine,   ///< The joints cannot follow the line, or not so fast.
  kInCollision,  ///< The arm would touch something on the line.
  kNoWay,        ///< No way to where it begins was found.
  kFound,
};

struct PlannedSweep {
  SweepOutcome outcome{SweepOutcome::kUnreachable};
  hal::JointTrajectory approach;  ///< From where the arm is to where the sweep begins; empty: none.
  hal::JointTrajectory sweep;     ///< From there, at rest, to its end, at rest.
  std::string reason;             ///< Why there is none, with values; empty when found.

  double seconds() const { return approach.seconds() + sweep.seconds(); }
};

/// The laser on an arm, and where the arm is now.
struct LaserCarrier {
  std::vector<hal::JointInfo> joints;
  Pose X_WB{Pose::Identity()};  ///< Of the base, which stays there.
  Pose X_EL{Pose::Identity()};  ///< Of the laser on the end-effector.
  Eigen::VectorXd q;            ///< Joint angles [rad].
};

/// The motion of an arm for one scan: exactly the line, at a constant speed but for the run-up,
/// with nothing touched anywhere on it, or none and why. Of several ways to do it that whose
/// beginning is the soonest reached and which passes every check is taken. Deterministic: chance is
/// drawn from `seed`.
/// @throws ConfigError when `config` is not valid; InvalidArgument for a goal that is no rigid
/// transform or no length, or angles of the wrong number.
PlannedSweep PlanSweep(const SweepGoal& goal, const LaserCarrier& carrier,
                       const ArmCollision& collision, std::uint64_t seed,
                       const SweepConfig& config = {});

}  // namespace secondlook::planning
