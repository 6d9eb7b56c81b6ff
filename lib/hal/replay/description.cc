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

void Copy(const CameraInfo& camera, second_look::camera_t* message) {
  message->name = camera.name;
  message->width = camera.model.width;
  message->height = camera.model.height;
  message->fx = camera.model.fx;
  message->fy = camera.model.fy;
  message->cx = camera.model.cx;
  message->cy = camera.model.cy;
}

CameraInfo CameraIn(const second_look::camera_t& message, bool has_depth, double min_depth,
                    double max_depth) {
  const CameraInfo camera{
      message.name,
      {message.width, message.height, message.fx, message.fy, message.cx, message.cy},
      has_depth,
      min_depth,
      max_depth};
  try {
    camera.model.Validate("the recorded camera");
  } catch (const InvalidArgument& error) {
    throw ProtocolError(error.what());
  }
  return camera;
}

second_look::rec_arm_t Describe(const ArmInfo& arm, const CameraInfo& camera,
                                const kinematics::EyeInHand& hand) {
  second_look::rec_arm_t message{};
  message.name = arm.name;
  for (const JointInfo& joint : arm.joints) {
    message.joints.push_back({});
    message.joints.back().name = joint.name;
    message.joints.back().lower = joint.lower;
    message.joints.back().upper = joint.upper;
    message.joints.back().speed = joint.speed;
    message.joints.back().acceleration = joint.acceleration;
  }
  message.num_joints = static_cast<std::int32_t>(message.joints.size());
  message.urdf = hand.arm.model().urdf;
  message.tip = hand.arm.tip().name;
  Copy(hand.X_EC, message.X_EC);
  Copy(camera, &message.camera);
  message.camera_has_depth = camera.has_depth ? 1 : 0;
  message.camera_min_depth = camera.min_depth;
  message.camera_max_depth = camera.max_depth;
  return message;
}

ArmDescription ArmIn(const second_look::rec_arm_t& message) try {
  ArmDescription arm{
      {message.name, {}},
      CameraIn(message.camera, message.camera_has_depth != 0, message.camera_min_depth,
               message.camera_max_depth),
      {kinematics::Chain(kinematics::ParseUrdf(message.urdf, "the recorded URDF"), message.tip),
       PoseIn(message.X_EC, "X_EC")}};
  for (const second_look::rec_joint_t& joint : message.joints) {
    arm.arm.joints.push_back(
        {joint.name, joint.lower, joint.upper, joint.speed, joint.acceleration});
  }
  return arm;
} catch (const ConfigError& error) {
  throw ProtocolError(error.what());
}

}  // namespace

void Describe(const Robot& robot, const kinematics::HeadCalibration& calibration,
              const std::optional<kinematics::EyeInHand>& hand,
              second_look::rec_mission_t* mission) {
  Copy(calibration.X_BH0, mission->X_BH0);
  Copy(calibration.X_HC, mission->X_HC);

  const CameraInfo& camera = robot.head_camera->info();
  Copy(camera, &mission->camera);
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

  if (hand) mission->arms.push_back(Describe(robot.arm->info(), robot.hand_camera->info(), *hand));
  mission->num_arms = static_cast<std::int32_t>(mission->arms.size());
}

RobotDescription DescriptionIn(const second_look::rec_mission_t& mission) {
  RobotDescription robot;
  robot.calibration = {PoseIn(mission.X_BH0, "X_BH0"), PoseIn(mission.X_HC, "X_HC")};
  robot.head_camera = CameraIn(mission.camera, mission.camera_has_depth != 0,
                               mission.camera_min_depth, mission.camera_max_depth);
  robot.base = {mission.base_name, mission.base_radius, mission.base_height, mission.base_speed,
                mission.base_turn_rate};
  robot.head = {mission.head_name,
                {mission.head_lower[0], mission.head_lower[1]},
                {mission.head_upper[0], mission.head_upper[1]},
                mission.head_speed};
  if (!mission.arms.empty()) robot.arm = ArmIn(mission.arms.front());
  return robot;
}

}  // namespace secondlook::hal
