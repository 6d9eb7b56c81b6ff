#include "lib/hal/replay/recording.h"

#include <algorithm>
#include <utility>

#include "lib/common/error.h"
#include "lib/transport/channels.h"
#include "lib/transport/event_log.h"
#include "lib/transport/message_json.h"

#include "second_look/mission_t.hpp"
#include "second_look/rec_arm_state_t.hpp"
#include "second_look/rec_base_state_t.hpp"
#include "second_look/rec_clock_t.hpp"
#include "second_look/rec_frame_t.hpp"
#include "second_look/rec_head_state_t.hpp"
#include "second_look/rec_motion_t.hpp"
#include "second_look/rec_new_model_t.hpp"

namespace secondlook::hal {
namespace {

namespace channel = transport::channel;
using second_look::rec_clock_t;
using second_look::rec_error_t;
using second_look::rec_image_t;
using second_look::rec_motion_t;

Time FromNanoseconds(std::int64_t ns) { return Time(Duration(ns)); }

Pose2 ToPose2(const double list[3]) { return {list[0], list[1], list[2]}; }

/// @throws ProtocolError for bytes that are no T.
template <class T>
T Decode(const transport::LogEvent& event) {
  transport::Check(event.bytes, transport::TypeOn(event.channel));
  T body{};
  body.decode(event.bytes.data(), 0, static_cast<int>(event.bytes.size()));
  return body;
}

BaseState ToState(const second_look::rec_base_state_t& message) {
  BaseState state;
  state.time = FromNanoseconds(message.time_ns);
  state.X_WB = ToPose2(message.X_WB);
  state.X_OB = ToPose2(message.X_OB);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) state.covariance_WB(i, j) = message.covariance_WB[i][j];
  }
  return state;
}

/// The images of the next frame of a camera, until it comes.
class NextFrame {
 public:
  void Add(rec_image_t image) {
    (image.image == rec_image_t::COLOR ? color_ : depth_).push_back(std::move(image));
  }

  Grabbed Take(const second_look::rec_frame_t& message) {
    Grabbed grabbed;
    grabbed.now = FromNanoseconds(message.now_ns);
    grabbed.came = message.came != 0;
    grabbed.frame.time = FromNanoseconds(message.time_ns);
    grabbed.frame.sequence = static_cast<std::uint64_t>(message.sequence);
    grabbed.color = std::exchange(color_, {});
    grabbed.depth = std::exchange(depth_, {});
    for (auto* pieces : {&grabbed.color, &grabbed.depth}) {
      std::erase_if(*pieces, [&](const auto& p) { return p.sequence != message.sequence; });
    }
    return grabbed;
  }

 private:
  std::vector<rec_image_t> color_, depth_;
};

/// Sorts the events of a log into a recording.
class Loader {
 public:
  explicit Loader(const std::filesystem::path& file) : file_(file), log_(file) {}

  Recording Load() {
    while (const std::optional<transport::LogEvent> event = log_.Next()) {
      try {
        Add(*event);
      } catch (const ProtocolError&) {
        ++unreadable_;
      }
    }
    if (!begun_) {
      Throw<ConfigError>("{}: is no recording of a mission: nothing on {} can be read in it",
                         file_.string(), channel::kRecMission);
    }
    AddWarnings();
    return std::move(recording_);
  }

 private:
  void Add(const transport::LogEvent& event) {
    if (event.channel == channel::kRecMission) {
      Begin(Decode<second_look::rec_mission_t>(event));
    } else if (!begun_ && event.channel.starts_with("REC_")) {
      ++early_;
    } else if (event.channel.starts_with("REC_")) {
      AddInput(event, &recording_.segments.back());
    } else if (event.channel.starts_with("SECONDLOOK_")) {
      AddTold(event);
    }
  }

  void Begin(const second_look::rec_mission_t& start) {
    if (start.format != second_look::rec_mission_t::FORMAT) {
      Throw<ConfigError>("{}: is a recording of format {}; this program reads format {}",
                         file_.string(), start.format,
                         static_cast<int>(second_look::rec_mission_t::FORMAT));
    }
    recording_.robot = DescriptionIn(start);
    recording_.start = start;
    recording_.segments.resize(1);
    begun_ = true;
  }

  void AddTold(const transport::LogEvent& event) {
    const std::string_view type = transport::TypeOn(event.channel);
    if (type.empty()) return;
    transport::Check(event.bytes, type);
    recording_.told.push_back({event.channel, event.utime, event.bytes});
    if (event.channel == channel::kLook) recording_.segments.emplace_back();
    if (event.channel == channel::kMission) {
      recording_.complete |= !Decode<second_look::mission_t>(event).end.empty();
    }
  }

  void AddInput(const transport::LogEvent& event, Segment* segment) {
    const std::string& name = event.channel;
    if (name == channel::kRecClock) {
      AddClock(Decode<rec_clock_t>(event), segment);
    } else if (name == channel::kRecBaseState) {
      segment->base_states.emplace_back(ToState(Decode<second_look::rec_base_state_t>(event)));
    } else if (name == channel::kRecHeadState) {
      const auto state = Decode<second_look::rec_head_state_t>(event);
      segment->head_states.emplace_back(
          PanTiltState{FromNanoseconds(state.time_ns), {state.pan, state.tilt}});
    } else if (name == channel::kRecBaseMotion) {
      AddMotion(Decode<rec_motion_t>(event), &segment->base_starts, &segment->base_statuses);
    } else if (name == channel::kRecHeadMotion) {
      AddMotion(Decode<rec_motion_t>(event), &segment->head_starts, &segment->head_statuses);
    } else if (name == channel::kRecArmState) {
      const auto state = Decode<second_look::rec_arm_state_t>(event);
      segment->arm_states.emplace_back(
          ArmState{FromNanoseconds(state.time_ns),
                   Eigen::Map<const Eigen::VectorXd>(state.q.data(), std::ssize(state.q))});
    } else if (name == channel::kRecArmMotion) {
      AddMotion(Decode<rec_motion_t>(event), &segment->arm_starts, &segment->arm_statuses);
    } else if (name == channel::kRecImage) {
      head_.Add(Decode<rec_image_t>(event));
    } else if (name == channel::kRecFrame) {
      segment->frames.emplace_back(head_.Take(Decode<second_look::rec_frame_t>(event)));
    } else if (name == channel::kRecHandImage) {
      hand_.Add(Decode<rec_image_t>(event));
    } else if (name == channel::kRecHandFrame) {
      segment->hand_frames.emplace_back(hand_.Take(Decode<second_look::rec_frame_t>(event)));
    } else if (name == channel::kRecError) {
      AddError(Decode<rec_error_t>(event), segment);
    } else if (name == channel::kRecStop) {
      segment->stop = Decode<second_look::rec_stop_t>(event);
    } else if (name == channel::kRecTask) {
      segment->tasks.push_back(Decode<second_look::task_t>(event));
    } else if (name == channel::kRecNewModel) {
      segment->models.push_back(Decode<second_look::rec_new_model_t>(event).model);
    }
  }

  static void AddClock(const rec_clock_t& clock, Segment* segment) {
    auto& times = clock.call == rec_clock_t::NOW     ? segment->now
                  : clock.call == rec_clock_t::SLEEP ? segment->slept
                                                     : segment->thought;
    times.push_back(FromNanoseconds(clock.now_ns));
  }

  static void AddMotion(const rec_motion_t& motion, std::vector<Answer<Started>>* starts,
                        std::vector<Answer<MotionStatus>>* statuses) {
    if (motion.call == rec_motion_t::START) {
      starts->emplace_back(Started{});
      return;
    }
    if (motion.phase < 0 || motion.phase > static_cast<int>(MotionPhase::kStopped)) {
      Throw<ProtocolError>("there is no phase {}", motion.phase);
    }
    statuses->emplace_back(MotionStatus{static_cast<MotionPhase>(motion.phase), motion.reason});
  }

  static void AddError(const rec_error_t& error, Segment* segment) {
    switch (error.call) {
      case rec_error_t::BASE_STATE:
        segment->base_states.emplace_back(error);
        break;
      case rec_error_t::BASE_START:
        segment->base_starts.emplace_back(error);
        break;
      case rec_error_t::BASE_STATUS:
        segment->base_statuses.emplace_back(error);
        break;
      case rec_error_t::HEAD_STATE:
        segment->head_states.emplace_back(error);
        break;
      case rec_error_t::HEAD_START:
        segment->head_starts.emplace_back(error);
        break;
      case rec_error_t::HEAD_STATUS:
        segment->head_statuses.emplace_back(error);
        break;
      case rec_error_t::GRAB:
        segment->frames.emplace_back(error);
        break;
      case rec_error_t::ARM_STATE:
        segment->arm_states.emplace_back(error);
        break;
      case rec_error_t::ARM_START:
        segment->arm_starts.emplace_back(error);
        break;
      case rec_error_t::ARM_STATUS:
        segment->arm_statuses.emplace_back(error);
        break;
      case rec_error_t::HAND_GRAB:
        segment->hand_frames.emplace_back(error);
        break;
      default:
        Throw<ProtocolError>("there is no call {}", error.call);
    }
  }

  void AddWarnings() {
    const auto warn = [&](std::string text) { recording_.warnings.push_back(std::move(text)); };
    const transport::LogDamage& damage = log_.damage();
    const std::string name = file_.string();
    if (damage.cut_off_bytes > 0) {
      warn(fmt::format("{}: is cut off within a message: its last {} bytes are left out", name,
                       damage.cut_off_bytes));
    }
    if (damage.places > 0) {
      warn(fmt::format("{}: is damaged in {} places: {} bytes are left out", name, damage.places,
                       damage.bytes));
    }
    if (unreadable_ > 0) warn(fmt::format("{}: {} messages are damaged", name, unreadable_));
    if (early_ > 0) {
      warn(fmt::format("{}: {} messages from before the mission's beginning are left out", name,
                       early_));
    }
    if (!recording_.complete) {
      warn(fmt::format("{}: ends before the mission does, after look {}", name,
                       recording_.segments.size() - 1));
    }
  }

  std::filesystem::path file_;
  transport::EventLogReader log_;
  Recording recording_;
  bool begun_{};
  NextFrame head_;
  NextFrame hand_;
  int unreadable_{};
  int early_{};
};

}  // namespace

Recording Recording::Load(const std::filesystem::path& file) { return Loader(file).Load(); }

}  // namespace secondlook::hal
