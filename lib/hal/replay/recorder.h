#pragma once

#include <cstdint>

#include "lib/hal/tap.h"
#include "lib/transport/message.h"

#include "second_look/rec_mission_t.hpp"
#include "second_look/task_t.hpp"

namespace secondlook::hal {

/// Turns everything that comes in at the devices of a tapped robot into the REC_ messages of
/// docs/recording.md, without loss, in the order in which it came.
/// Threading: one thread, the mission's.
class Recorder : public RobotListener {
 public:
  /// `log` must outlive this.
  explicit Recorder(transport::Sink* log) : log_(log) {}

  /// What the mission begins with, before anything is asked of the robot.
  void Begin(second_look::rec_mission_t mission);
  /// The mission has got this task.
  void Task(second_look::task_t task);
  /// The mission has got this model.
  void NewModel(second_look::rec_model_t model);
  /// The mission has asked whether to stop, and was answered `stop`; `signal` wanted it, or 0. The
  /// first time that it is to stop is recorded.
  void StopAsked(bool stop, int signal);

  void OnNow(Time now) override;
  void OnSleep(Time until, Time now) override;
  void OnThinking(Duration cost, Time now) override;
  void OnBaseState(const BaseState& state) override;
  void OnBaseStart(const BasePath& path) override;
  void OnBaseStatus(const MotionStatus& status) override;
  void OnHeadState(const PanTiltState& state) override;
  void OnHeadStart(const PanTiltAngles& target) override;
  void OnHeadStatus(const MotionStatus& status) override;
  void OnArmState(const ArmState& state) override;
  void OnArmStart(const JointTrajectory& trajectory) override;
  void OnArmStatus(const MotionStatus& status) override;
  void OnFrame(const std::optional<RgbdFrame>& frame, Time now) override;
  void OnHandFrame(const std::optional<RgbdFrame>& frame, Time now) override;
  void OnError(Call call, const Error& error, Time now) override;

 private:
  template <class T>
  void Post(const char* channel, T body);
  void PostClock(std::int8_t call, std::int64_t asked_ns, Time now);
  void PostMotion(const char* channel, std::int8_t call, const MotionStatus& status);
  void PostFrame(const char* image_channel, const char* frame_channel,
                 const std::optional<RgbdFrame>& frame, Time now);

  transport::Sink* log_;
  Time now_{};
  std::int64_t stop_questions_{};  ///< That the mission has asked.
  bool stopped_{};
};

}  // namespace secondlook::hal
