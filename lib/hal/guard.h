#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/common/time.h"
#include "lib/hal/robot.h"

namespace secondlook::hal {

/// Where the middle of the base may be on the floor: a rectangle along the axes of W.
struct Workspace {
  Eigen::Vector2d x{-100.0, 100.0};  ///< From, to [m].
  Eigen::Vector2d y{-100.0, 100.0};  ///< Likewise.

  bool Contains(double px, double py) const {
    return px >= x[0] && px <= x[1] && py >= y[0] && py <= y[1];
  }

  template <class A>
  void Serialize(A* a) {
    a->Visit("x", &x);
    a->Visit("y", &y);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// What an arm and all in its hand may not leave: a box along the axes of B.
struct ArmWorkspace {
  Eigen::Vector2d x{-100.0, 100.0};  ///< From, to [m].
  Eigen::Vector2d y{-100.0, 100.0};  ///< Likewise.
  Eigen::Vector2d z{-100.0, 100.0};  ///< Likewise.

  Eigen::AlignedBox3d box_B() const {
    return Eigen::AlignedBox3d(Eigen::Vector3d(x[0], y[0], z[0]),
                               Eigen::Vector3d(x[1], y[1], z[1]));
  }

  template <class A>
  void Serialize(A* a) {
    a->Visit("x", &x);
    a->Visit("y", &y);
    a->Visit("z", &z);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// The box along the axes of B around all that an arm moves, at the joint angles `q` [rad]
/// (kinematics::BoxOfMoved).
using ArmBox = std::function<Eigen::AlignedBox3d(const Eigen::VectorXd& q)>;

/// What no motion of the robot may exceed, whoever asks for it. A speed of 0: what the device is
/// configured to.
struct GuardConfig {
  double base_speed{};                        ///< At most [m/s].
  double base_turn_rate_deg{};                ///< At most [deg/s].
  double head_speed_deg{};                    ///< At most, of each axis [deg/s].
  double arm_speed_deg{};                     ///< At most, of each joint [deg/s].
  std::optional<Workspace> workspace;         ///< None: everywhere.
  std::optional<ArmWorkspace> arm_workspace;  ///< None: everywhere.
  /// A motion that nobody has asked about for so long is stopped [s of robot time].
  double lapse_seconds{2.0};

  template <class A>
  void Serialize(A* a) {
    a->Visit("base_speed", &base_speed);
    a->Visit("base_turn_rate_deg", &base_turn_rate_deg);
    a->Visit("head_speed_deg", &head_speed_deg);
    a->Visit("arm_speed_deg", &arm_speed_deg);
    a->Visit("workspace", &workspace);
    a->Visit("arm_workspace", &arm_workspace);
    a->Visit("lapse_seconds", &lapse_seconds);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A motion in progress, seen by other threads than the one that polls it.
struct GuardedMotion {
  std::string device;
  std::atomic<bool> moving{false};
  std::atomic<Time::rep> renewed{0};  ///< When somebody last asked how far it is [robot time].
};

/// The one place through which every motion goes on its way to an actuator. It
/// - refuses motions while a protective stop holds, and out of the workspace: such a motion ends at
///   once, stopped or failed, with the reason;
/// - stops a base that drives faster than it may, or out of the workspace, by its odometry and
///   localisation, and an arm that leaves its own by its encoders, and fails the motion;
/// - keeps the laser dark while a protective stop holds;
/// - knows which motions lapse unasked, and throws ProtocolError for a State() that is not finite.
/// A protective stop is one of this process. It is not an emergency stop.
/// Threading: Protect() once, from the thread that moves the robot; the rest from any.
class Guard {
 public:
  /// @throws ConfigError when `config` is not valid.
  explicit Guard(const GuardConfig& config);
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  /// The same robot, behind this guard, which must outlive it.
  /// @param arm_box Of the robot's arm; needed when it has a workspace.
  /// @throws ConfigError for a device that is configured to be faster than it may be, and for a
  /// workspace of an arm that there is not.
  Robot Protect(Robot robot, const ArmBox& arm_box = {});

  /// From now on nothing moves until Clear(). What moves is still to be stopped: Robot::Stop().
  /// The first reason is kept.
  void Hold(const std::string& why);
  void Clear();
  bool holds() const { return holds_; }
  /// Why nothing moves; empty when it may.
  std::string why() const;

  /// Which device moves although nobody has asked about it for too long; empty when none does.
  std::string Lapsed() const;

  const GuardConfig& config() const { return config_; }

 private:
  GuardConfig config_;
  const Clock* clock_{};
  std::vector<std::unique_ptr<GuardedMotion>> motions_;
  std::atomic<bool> holds_{false};
  mutable std::mutex mutex_;  // of why_
  std::string why_;
};

}  // namespace secondlook::hal
