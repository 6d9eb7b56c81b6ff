#include "lib/transport/channels.h"

namespace secondlook::transport {

const std::vector<ChannelType>& Channels() {
  static const std::vector<ChannelType> channels{
      {channel::kMission, "second_look.mission_t"},
      {channel::kStatus, "second_look.status_t"},
      {channel::kImage, "bot_core.images_t"},
      {channel::kView, "second_look.view_t"},
      {channel::kPlane, "second_look.support_plane_t"},
      {channel::kObjects, "second_look.objects_t"},
      {channel::kOccupancy, "second_look.occupancy_t"},
      {channel::kCandidates, "second_look.candidates_t"},
      {channel::kLook, "second_look.look_t"},
      {channel::kNavGoal, "second_look.nav_goal_t"},
      {channel::kNavStatus, "second_look.nav_status_t"},
      {channel::kTiming, "second_look.timing_t"},
      {channel::kTask, "second_look.task_t"},
      {channel::kCommand, "second_look.command_t"},
  };
  return channels;
}

const std::vector<ChannelType>& DeviceChannels() {
  static const std::vector<ChannelType> channels{
      {channel::kBaseGoal, "second_look.base_goal_t"},
      {channel::kBaseCancel, "second_look.base_cancel_t"},
      {channel::kBaseStatus, "second_look.base_status_t"},
      {channel::kBasePose, "second_look.base_pose_t"},
      {channel::kStriperCommand, "second_look.striper_command_t"},
      {channel::kStriperStatus, "second_look.striper_status_t"},
      {channel::kStriperLine, "second_look.striper_line_t"},
  };
  return channels;
}

const std::vector<ChannelType>& RecordingChannels() {
  static const std::vector<ChannelType> channels{
      {channel::kRecMission, "second_look.rec_mission_t"},
      {channel::kRecClock, "second_look.rec_clock_t"},
      {channel::kRecBaseState, "second_look.rec_base_state_t"},
      {channel::kRecBaseMotion, "second_look.rec_motion_t"},
      {channel::kRecHeadState, "second_look.rec_head_state_t"},
      {channel::kRecHeadMotion, "second_look.rec_motion_t"},
      {channel::kRecArmState, "second_look.rec_arm_state_t"},
      {channel::kRecArmMotion, "second_look.rec_motion_t"},
      {channel::kRecHandImage, "second_look.rec_image_t"},
      {channel::kRecHandFrame, "second_look.rec_frame_t"},
      {channel::kRecImage, "second_look.rec_image_t"},
      {channel::kRecFrame, "second_look.rec_frame_t"},
      {channel::kRecError, "second_look.rec_error_t"},
      {channel::kRecStop, "second_look.rec_stop_t"},
      {channel::kRecTask, "second_look.task_t"},
      {channel::kRecNewModel, "second_look.rec_new_model_t"},
  };
  return channels;
}

std::string_view TypeOn(std::string_view channel) {
  for (const auto* channels : {&Channels(), &DeviceChannels(), &RecordingChannels()}) {
    for (const ChannelType& c : *channels) {
      if (channel == c.channel) return c.type;
    }
  }
  return "";
}

}  // namespace secondlook::transport
