#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/time.h"
#include "lib/hal/joint_trajectory.h"
#include "lib/hal/motion.h"

namespace secondlook::hal {

/// What an arm is. Constant for its lifetime.
struct ArmInfo {
  std::string name;               ///< What messages call it.
  std::vector<JointInfo> joints;  ///< From the base to the tip.
};

/// The measured joint positions of an arm.
struct ArmState {
  Time time{};        ///< Of the measurement.
  Eigen::VectorXd q;  ///< As its encoders say [rad], base to tip.
};

/// An arm of revolute joints: a real one behind a servo thread of its own, a replayed log or the
/// simulation. It takes a whole trajectory and can hold or stop by itself. Every backend passes
/// tests/hal/arm_contract.h.
/// Threading: Stop() from any thread, the rest from one.
class Arm {
 public:
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;
  /// Leaves the arm standing still.
  virtual ~Arm() = default;

  virtual const ArmInfo& info() const = 0;

  /// The newest state. Times never decrease.
  /// @throws DeviceError naming the arm if it is lost or its state is stale.
  virtual ArmState State() = 0;

  /// Begins to follow `trajectory` and returns at once. A motion in progress is never replaced, as
  /// a trajectory begins at rest: stop it first, or let it end.
  /// @throws InvalidArgument as CheckTrajectory(), or when the arm moves; what it does goes on
  /// then.
  /// @throws DeviceError naming the arm if it is lost.
  virtual void Start(const JointTrajectory& trajectory) = 0;

  /// How far the last trajectory is. kReached: each joint within 0.5 degrees of its end by the
  /// encoders, and standing still.
  virtual MotionStatus Status() = 0;

  /// Brakes to a standstill along the trajectory, as soon as it can. Always possible, also when
  /// nothing moves.
  virtual void Stop() noexcept = 0;

 protected:
  Arm() = default;
};

}  // namespace secondlook::hal
