#include "lib/hal/replay/description.h"

#include <cmath>

#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

void Copy(const Pose& X_AB, double matrix[4][4]) {
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) matrix[i][j] = X_AB.matrix()(i, j);
  }
}

Pose PoseIn(const double matrix[4][4], const char* name) {
  Pose X_AB;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) X_AB.matrix()(i, j) = matrix[i][j];
  }
  if (!IsValid(X_AB)) Throw<ProtocolError>("the recorded {} is no rigid transform", name);
  return X_AB;
}

}  // namespace

void Describe(const Robot& robot, const kinematics::HeadCalibration& calibration,
              second_look::rec_mission_t* mission) {
  Copy(calibration.X_BH0, mission->X_BH0);
  Copy(calibration.X_HC, mission->X_HC);

  const CameraInfo& camera = robot.head_camera->info();
  mission->camera.name = camera.name;
  mission->camera.width = camera.model.width;
  mission->camera.height = camera.model.height;
  mission->camera.fx = camera.model.fx;
  mission->camera.fy = camera.model.fy;
  mission->camera.cx = camera.model.cx;
  mission->camera.cy = camera.model.cy;
  mission->camera_has_depth = camera.has_depth ? 1 : 0;
  mission->camera_min_depth = camera.min_depth;
  mission->camera_max_depth = camera.max_depth;

  const BaseInfo& base = robot.base->info();
  mission->base_name = base.name;
  mission->base_radius = base.radius;
  mission->base_height = base.height;
  mission->base_speed = base.speed;
  mission->base_turn_rate = base.turn_rate;

  const PanTiltInfo& head = robot.head->info();
  mission->head_name = head.name;
  mission->head_lower[0] = head.lower.pan;
  mission->head_lower[1] = head.lower.tilt;
  mission->head_upper[0] = head.upper.pan;
  mission->head_upper[1] = head.upper.tilt;
  mission->head_speed = head.speed;
}

RobotDescription DescriptionIn(const second_look::rec_mission_t& mission) {
  RobotDescription robot;
  robot.calibration = {PoseIn(mission.X_BH0, "X_BH0"), PoseIn(mission.X_HC, "X_HC")};
  const second_look::camera_t& camera = mission.camera;
  robot.head_camera = {camera.name,
                       {camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy},
                       mission.camera_has_depth != 0,
                       mission.camera_min_depth,
                       mission.camera_max_depth};
  try {
    robot.head_camera.model.Validate("the recorded camera");
  } catch (const InvalidArgument& error) {
    throw ProtocolError(error.what());
  }
  robot.base = {mission.base_name, mission.base_radius, mission.base_height, mission.base_speed,
                mission.base_turn_rate};
  robot.head = {mission.head_name,
                {mission.head_lower[0], mission.head_lower[1]},
                {mission.head_upper[0], mission.head_upper[1]},
                mission.head_speed};
  return robot;
}

}  // namespace secondlook::hal
