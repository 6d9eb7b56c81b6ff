#pragma once

#include "lib/hal/robot.h"
#include "lib/kinematics/head.h"

#include "second_look/rec_mission_t.hpp"

namespace secondlook::hal {

/// What a recorded robot was.
struct RobotDescription {
  BaseInfo base;
  PanTiltInfo head;
  CameraInfo head_camera;
  kinematics::HeadCalibration calibration;
};

/// Enters what `robot` is into `mission`.
void Describe(const Robot& robot, const kinematics::HeadCalibration& calibration,
              second_look::rec_mission_t* mission);

/// What the robot of `mission` was. @throws ProtocolError for what no robot can be.
RobotDescription DescriptionIn(const second_look::rec_mission_t& mission);

}  // namespace secondlook::hal
