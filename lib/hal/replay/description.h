#pragma once

#include <optional>

#include "lib/hal/robot.h"
#include "lib/kinematics/eye_in_hand.h"
#include "lib/kinematics/head.h"

#include "second_look/rec_mission_t.hpp"

namespace secondlook::hal {

/// What a recorded arm was, with the camera in its hand.
struct ArmDescription {
  ArmInfo arm;
  CameraInfo camera;
  kinematics::EyeInHand hand;
};

/// What a recorded robot was.
struct RobotDescription {
  BaseInfo base;
  PanTiltInfo head;
  CameraInfo head_camera;
  kinematics::HeadCalibration calibration;
  std::optional<ArmDescription> arm;  ///< Empty: it had none.
};

/// Enters what `robot` is into `mission`; `hand` when it has an arm.
void Describe(const Robot& robot, const kinematics::HeadCalibration& calibration,
              const std::optional<kinematics::EyeInHand>& hand,
              second_look::rec_mission_t* mission);

/// What the robot of `mission` was. @throws ProtocolError for what no robot can be.
RobotDescription DescriptionIn(const second_look::rec_mission_t& mission);

}  // namespace secondlook::hal
