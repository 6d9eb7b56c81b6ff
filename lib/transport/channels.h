#pragma once

#include <string_view>
#include <vector>

namespace secondlook::transport {

/// The channels of docs/channels.md.
namespace channel {
inline constexpr const char* kMission = "SECONDLOOK_MISSION";
inline constexpr const char* kStatus = "SECONDLOOK_STATUS";
inline constexpr const char* kImage = "SECONDLOOK_IMAGE";
inline constexpr const char* kView = "SECONDLOOK_VIEW";
inline constexpr const char* kPlane = "SECONDLOOK_PLANE";
inline constexpr const char* kObjects = "SECONDLOOK_OBJECTS";
inline constexpr const char* kOccupancy = "SECONDLOOK_OCCUPANCY";
inline constexpr const char* kCandidates = "SECONDLOOK_CANDIDATES";
inline constexpr const char* kLook = "SECONDLOOK_LOOK";
inline constexpr const char* kNavGoal = "SECONDLOOK_NAV_GOAL";
inline constexpr const char* kNavStatus = "SECONDLOOK_NAV_STATUS";
inline constexpr const char* kTiming = "SECONDLOOK_TIMING";
inline constexpr const char* kTask = "SECONDLOOK_TASK";        ///< In.
inline constexpr const char* kCommand = "SECONDLOOK_COMMAND";  ///< In.

// Between the driver of a base and what drives it (docs/real_robot.md).
inline constexpr const char* kBaseGoal = "BASE_GOAL";      ///< Out.
inline constexpr const char* kBaseCancel = "BASE_CANCEL";  ///< Out.
inline constexpr const char* kBaseStatus = "BASE_STATUS";  ///< In.
inline constexpr const char* kBasePose = "BASE_POSE";      ///< In.

// Between the driver of a laser striper and what measures (docs/real_robot.md).
inline constexpr const char* kStriperCommand = "STRIPER_COMMAND";  ///< Out.
inline constexpr const char* kStriperStatus = "STRIPER_STATUS";    ///< In.
inline constexpr const char* kStriperLine = "STRIPER_LINE";        ///< In.

// What comes in at the devices, in a recording alone (docs/recording.md).
inline constexpr const char* kRecMission = "REC_MISSION";
inline constexpr const char* kRecClock = "REC_CLOCK";
inline constexpr const char* kRecBaseState = "REC_BASE_STATE";
inline constexpr const char* kRecBaseMotion = "REC_BASE_MOTION";
inline constexpr const char* kRecHeadState = "REC_HEAD_STATE";
inline constexpr const char* kRecHeadMotion = "REC_HEAD_MOTION";
inline constexpr const char* kRecArmState = "REC_ARM_STATE";
inline constexpr const char* kRecArmMotion = "REC_ARM_MOTION";
inline constexpr const char* kRecHandImage = "REC_HAND_IMAGE";
inline constexpr const char* kRecHandFrame = "REC_HAND_FRAME";
inline constexpr const char* kRecImage = "REC_IMAGE";
inline constexpr const char* kRecFrame = "REC_FRAME";
inline constexpr const char* kRecError = "REC_ERROR";
inline constexpr const char* kRecStop = "REC_STOP";
inline constexpr const char* kRecTask = "REC_TASK";
inline constexpr const char* kRecNewModel = "REC_NEW_MODEL";
}  // namespace channel

/// No message of ours is longer [bytes]: longer ones are lost in a default socket buffer.
inline constexpr std::size_t kMaxMessageBytes = 100'000;

/// A channel and what is on it.
struct ChannelType {
  const char* channel;
  const char* type;  ///< As messages/ names it, e.g. "second_look.view_t".
};

/// All channels of the bus, those we listen to included.
const std::vector<ChannelType>& Channels();

/// The channels of devices.
const std::vector<ChannelType>& DeviceChannels();

/// The channels that are in a recording alone.
const std::vector<ChannelType>& RecordingChannels();

/// The type of what is on `channel`; empty for a channel of no kind.
std::string_view TypeOn(std::string_view channel);

}  // namespace secondlook::transport
