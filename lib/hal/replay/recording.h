#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lib/common/time.h"
#include "lib/hal/replay/description.h"
#include "lib/hal/robot.h"
#include "lib/transport/message.h"

#include "second_look/rec_error_t.hpp"
#include "second_look/rec_image_t.hpp"
#include "second_look/rec_mission_t.hpp"
#include "second_look/rec_stop_t.hpp"
#include "second_look/task_t.hpp"

namespace secondlook::hal {

/// What a device answered when it was asked, or the error it threw.
template <class T>
using Answer = std::variant<T, second_look::rec_error_t>;

/// The answer to Start().
struct Started {};

/// The answer to Grab().
struct Grabbed {
  Time now;  ///< When it came.
  bool came{};
  RgbdFrame frame;  ///< Without its images, which are still encoded.
  std::vector<second_look::rec_image_t> color;
  std::vector<second_look::rec_image_t> depth;
};

/// What came in from one look to the next: between two SECONDLOOK_LOOK messages, which a mission
/// sends when it sets out. For each function of the devices its answers, in their order.
struct Segment {
  std::vector<Time> now, slept, thought;  ///< When the clock's functions returned.
  std::vector<Answer<BaseState>> base_states;
  std::vector<Answer<Started>> base_starts;
  std::vector<Answer<MotionStatus>> base_statuses;
  std::vector<Answer<PanTiltState>> head_states;
  std::vector<Answer<Started>> head_starts;
  std::vector<Answer<MotionStatus>> head_statuses;
  std::vector<Answer<ArmState>> arm_states;
  std::vector<Answer<Started>> arm_starts;
  std::vector<Answer<MotionStatus>> arm_statuses;
  std::vector<Answer<Grabbed>> frames;           ///< Of the camera on the head.
  std::vector<Answer<Grabbed>> hand_frames;      ///< Of that in the hand.
  std::vector<second_look::task_t> tasks;        ///< That were set, all at once.
  std::vector<second_look::rec_model_t> models;  ///< That were added to the database.
  std::optional<second_look::rec_stop_t> stop;   ///< The mission was to stop.
};

/// What Recorder has written, read back.
struct Recording {
  /// Reads the log `file` and its further parts. What is damaged in it is left out.
  /// @throws ConfigError when it cannot be read, is no recording, or one of another format.
  static Recording Load(const std::filesystem::path& file);

  second_look::rec_mission_t start;
  RobotDescription robot;
  std::vector<Segment> segments;         ///< At least one.
  std::vector<transport::Message> told;  ///< What the mission told on its SECONDLOOK_ channels.
  bool complete{};                       ///< The mission's end was recorded.
  std::vector<std::string> warnings;     ///< What is damaged or missing, in words.
};

}  // namespace secondlook::hal
