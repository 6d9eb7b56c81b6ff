#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/common/time.h"
#include "lib/hal/motion.h"

namespace secondlook::hal {

/// What a mobile base is. Constant for its lifetime.
struct BaseInfo {
  std::string name;    ///< What messages call it.
  double radius{};     ///< Of the upright cylinder about B's z axis that holds it all [m].
  double height{};     ///< Of that cylinder, from the floor [m].
  double speed{};      ///< Cruising [m/s], > 0.
  double turn_rate{};  ///< Turning on the spot [rad/s], > 0.
};

/// Where the base is, as localisation knows it.
struct BaseState {
  Time time{};  ///< Of the measurement.
  Pose2 X_WB;   ///< Localisation's estimate, with its error: centimetres and a degree are usual.
  Pose2 X_OB;   ///< Odometry: smooth, drifting.
  Eigen::Matrix3d covariance_WB{Eigen::Matrix3d::Zero()};  ///< Of (x, y, yaw) [m, m, rad].
};

/// A way to drive. The base turns on the spot and drives straight from waypoint to waypoint, then
/// turns to the last one's heading; the headings of the others are ignored. A navigation stack may
/// take a way of its own to the last one.
struct BasePath {
  std::vector<Pose2> waypoints_W;  ///< At least one; the last is the goal X_WB.
};

/// A mobile base behind its localisation: a navigation stack on the robot, a replayed log or the
/// simulation. Every backend passes tests/hal/base_contract.h.
/// Threading: Stop() from any thread, the rest from one.
class Base {
 public:
  Base(const Base&) = delete;
  Base& operator=(const Base&) = delete;
  /// Leaves the base standing still.
  virtual ~Base() = default;

  virtual const BaseInfo& info() const = 0;

  /// The newest state. Times never decrease; two polls faster than the device return the same one.
  /// @throws DeviceError naming the base if it is lost.
  virtual BaseState State() = 0;

  /// Begins to drive and returns at once; a path in progress is replaced. The base keeps clear of
  /// what its own safety sensors see: where something stands in the way it stops and fails.
  /// @throws InvalidArgument for an empty path or a waypoint that is not finite.
  /// @throws DeviceError naming the base if it is lost.
  virtual void Start(const BasePath& path) = 0;

  /// How far the last path is. kReached: within 0.1 m and 5 degrees of the goal as localisation
  /// sees it, and standing still.
  virtual MotionStatus Status() = 0;

  /// Stands still as soon as it can. Always possible, also when nothing moves.
  virtual void Stop() noexcept = 0;

 protected:
  Base() = default;
};

}  // namespace secondlook::hal
