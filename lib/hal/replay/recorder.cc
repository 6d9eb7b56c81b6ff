#include "lib/hal/replay/recorder.h"

#include <cstdint>
#include <utility>

#include "lib/hal/replay/frame_codec.h"
#include "lib/transport/channels.h"

#include "second_look/rec_arm_state_t.hpp"
#include "second_look/rec_base_state_t.hpp"
#include "second_look/rec_clock_t.hpp"
#include "second_look/rec_error_t.hpp"
#include "second_look/rec_frame_t.hpp"
#include "second_look/rec_head_state_t.hpp"
#include "second_look/rec_motion_t.hpp"
#include "second_look/rec_new_model_t.hpp"
#include "second_look/rec_stop_t.hpp"

namespace secondlook::hal {
namespace {

namespace channel = transport::channel;
using second_look::rec_clock_t;
using second_look::rec_error_t;
using second_look::rec_motion_t;

std::int64_t ToNanoseconds(Time time) { return time.time_since_epoch().count(); }

void Copy(const Pose2& pose, double list[3]) {
  list[0] = pose.x;
  list[1] = pose.y;
  list[2] = pose.yaw;
}

std::int8_t KindOf(const Error& error) {
  if (dynamic_cast<const ConfigError*>(&error) != nullptr) return rec_error_t::CONFIG;
  if (dynamic_cast<const InvalidArgument*>(&error) != nullptr) return rec_error_t::ARGUMENT;
  if (dynamic_cast<const ProtocolError*>(&error) != nullptr) return rec_error_t::PROTOCOL;
  return rec_error_t::DEVICE;
}

}  // namespace

template <class T>
void Recorder::Post(const char* channel, T body) {
  body.utime = ToNanoseconds(now_) / 1000;
  log_->Post(transport::Pack(channel, body));
}

void Recorder::Begin(second_look::rec_mission_t mission) {
  mission.format = second_look::rec_mission_t::FORMAT;
  Post(channel::kRecMission, std::move(mission));
}

void Recorder::Task(second_look::task_t task) { Post(channel::kRecTask, std::move(task)); }

void Recorder::NewModel(second_look::rec_model_t model) {
  second_look::rec_new_model_t message{};
  message.model = std::move(model);
  Post(channel::kRecNewModel, std::move(message));
}

void Recorder::StopAsked(bool stop, int signal) {
  ++stop_questions_;
  if (!stop || std::exchange(stopped_, true)) return;
  second_look::rec_stop_t message{};
  message.now_ns = ToNanoseconds(now_);
  message.questions = stop_questions_;
  message.signal = signal;
  Post(channel::kRecStop, message);
}

void Recorder::OnNow(Time now) { PostClock(rec_clock_t::NOW, 0, now); }

void Recorder::OnSleep(Time until, Time now) {
  PostClock(rec_clock_t::SLEEP, ToNanoseconds(until), now);
}

void Recorder::OnThinking(Duration cost, Time now) {
  PostClock(rec_clock_t::THINK, cost.count(), now);
}

void Recorder::PostClock(std::int8_t call, std::int64_t asked_ns, Time now) {
  now_ = now;
  rec_clock_t clock{};
  clock.call = call;
  clock.asked_ns = asked_ns;
  clock.now_ns = ToNanoseconds(now);
  Post(channel::kRecClock, clock);
}

void Recorder::OnBaseState(const BaseState& state) {
  second_look::rec_base_state_t message{};
  message.time_ns = ToNanoseconds(state.time);
  Copy(state.X_WB, message.X_WB);
  Copy(state.X_OB, message.X_OB);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) message.covariance_WB[i][j] = state.covariance_WB(i, j);
  }
  Post(channel::kRecBaseState, message);
}

void Recorder::OnHeadState(const PanTiltState& state) {
  second_look::rec_head_state_t message{};
  message.time_ns = ToNanoseconds(state.time);
  message.pan = state.angles.pan;
  message.tilt = state.angles.tilt;
  Post(channel::kRecHeadState, message);
}

void Recorder::OnBaseStart(const BasePath& /*path*/) {
  PostMotion(channel::kRecBaseMotion, rec_motion_t::START, {});
}

void Recorder::OnBaseStatus(const MotionStatus& status) {
  PostMotion(channel::kRecBaseMotion, rec_motion_t::STATUS, status);
}

void Recorder::OnHeadStart(const PanTiltAngles& /*target*/) {
  PostMotion(channel::kRecHeadMotion, rec_motion_t::START, {});
}

void Recorder::OnHeadStatus(const MotionStatus& status) {
  PostMotion(channel::kRecHeadMotion, rec_motion_t::STATUS, status);
}

void Recorder::OnArmState(const ArmState& state) {
  second_look::rec_arm_state_t message{};
  message.time_ns = ToNanoseconds(state.time);
  message.q.assign(state.q.begin(), state.q.end());
  message.num_joints = static_cast<std::int32_t>(message.q.size());
  Post(channel::kRecArmState, std::move(message));
}

void Recorder::OnArmStart(const JointTrajectory& /*trajectory*/) {
  PostMotion(channel::kRecArmMotion, rec_motion_t::START, {});
}

void Recorder::OnArmStatus(const MotionStatus& status) {
  PostMotion(channel::kRecArmMotion, rec_motion_t::STATUS, status);
}

void Recorder::PostMotion(const char* channel, std::int8_t call, const MotionStatus& status) {
  rec_motion_t motion{};
  motion.call = call;
  motion.phase = static_cast<std::int8_t>(status.phase);
  motion.reason = status.reason;
  Post(channel, std::move(motion));
}

void Recorder::OnFrame(const std::optional<RgbdFrame>& frame, Time now) {
  PostFrame(channel::kRecImage, channel::kRecFrame, frame, now);
}

void Recorder::OnHandFrame(const std::optional<RgbdFrame>& frame, Time now) {
  PostFrame(channel::kRecHandImage, channel::kRecHandFrame, frame, now);
}

void Recorder::PostFrame(const char* image_channel, const char* frame_channel,
                         const std::optional<RgbdFrame>& frame, Time now) {
  now_ = now;
  second_look::rec_frame_t message{};
  message.now_ns = ToNanoseconds(now);
  message.came = frame ? 1 : 0;
  if (frame) {
    for (second_look::rec_image_t& image : EncodeImages(*frame)) {
      Post(image_channel, std::move(image));
    }
    message.time_ns = ToNanoseconds(frame->time);
    message.sequence = static_cast<std::int64_t>(frame->sequence);
  }
  Post(frame_channel, message);
}

void Recorder::OnError(Call call, const Error& error, Time now) {
  now_ = now;
  rec_error_t message{};
  message.now_ns = ToNanoseconds(now);
  message.call = static_cast<std::int8_t>(call);
  message.kind = KindOf(error);
  message.what = error.what();
  Post(channel::kRecError, std::move(message));
}

}  // namespace secondlook::hal
