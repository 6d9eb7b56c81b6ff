#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "apps/run_config.h"
#include "lib/hal/guard.h"
#include "lib/hal/robot.h"
#include "lib/kinematics/eye_in_hand.h"
#include "lib/kinematics/head.h"
#include "sim/world.h"

namespace secondlook::apps {

/// A robot that is ready, and what it needs to live.
struct ReadyRobot {
  std::unique_ptr<sim::World> world;  ///< Null on a real robot. Outlives `robot`.
  hal::Robot robot;
  kinematics::HeadCalibration calibration;
  std::optional<kinematics::EyeInHand> hand;  ///< Of a robot with an arm.
  std::optional<Pose> X_EL{};                 ///< Of the laser on it, if it carries one.
};

/// Connects to the robot that `config` describes: the only place that knows every backend.
/// @throws ConfigError for a wrong configuration, DeviceError for a device that does not answer.
ReadyRobot MakeRobot(const RobotConfig& config, std::uint64_t seed);

/// Around the arm of `ready` and all in its hand; empty without one.
hal::ArmBox BoxOfArm(const ReadyRobot& ready);

}  // namespace secondlook::apps
