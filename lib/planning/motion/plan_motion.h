#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/hal/arm.h"
#include "lib/planning/motion/arm_collision.h"

namespace secondlook::planning {

struct MotionConfig {
  int iterations{2000};     ///< Of the search, at most.
  double range{0.8};        ///< Longest branch of the search's trees [rad, Euclidean].
  double step_m{0.02};      ///< No point of the arm moves farther between two collision tests.
  int shortcuts{60};        ///< Tried to make the way shorter.
  double speed_share{0.5};  ///< Of the joints' speed and acceleration limits that are used.

  template <class A>
  void Serialize(A* a) {
    a->Visit("iterations", &iterations);
    a->Visit("range", &range);
    a->Visit("step_m", &step_m);
    a->Visit("shortcuts", &shortcuts);
    a->Visit("speed_share", &speed_share);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// What came of planning a motion.
enum class MotionOutcome {
  kFound,
  kOutOfLimits,       ///< Start or goal lies beyond a joint's limits.
  kStartInCollision,  ///< The arm touches something where it is: it does not move by itself.
  kGoalInCollision,
  kNoWay,  ///< Not found within the iterations; there may be one.
};

struct PlannedMotion {
  MotionOutcome outcome{MotionOutcome::kNoWay};
  hal::JointTrajectory trajectory;  ///< From start to goal exactly; empty when there is none.
  std::string reason;               ///< Why there is none, with values; empty when found.
};

/// True when the straight way in joint angles from `a` to `b` is free, its ends included: tested so
/// densely that no point of the arm moves by more than `step_m` from one test to the next. A point
/// between two is then within half of it of one that was tested, so that with a clearance c the
/// exact body keeps c - step_m / 2 from everything.
bool StraightIsFree(const ArmCollision& collision, const Eigen::VectorXd& a,
                    const Eigen::VectorXd& b, double step_m);

/// A motion from `start` to `goal` [rad] that touches nothing and keeps every limit, the straight
/// one where that is free, else by RRT-Connect (OMPL; Kuffner and LaValle 2000), made shorter by
/// shortcuts. It ends at the goal exactly or there is none. Bounded by iterations, never by time.
/// Deterministic: all chance is drawn from `seed`; OMPL's own generators are not used.
/// @throws ConfigError when `config` is not valid, or a step of more than twice the clearance,
/// which could pass through things; InvalidArgument for angles of the wrong number or not finite,
/// or joints that are not those of the chain.
PlannedMotion PlanMotion(const ArmCollision& collision, const std::vector<hal::JointInfo>& joints,
                         const Eigen::VectorXd& start, const Eigen::VectorXd& goal,
                         std::uint64_t seed, const MotionConfig& config = {});

}  // namespace secondlook::planning
