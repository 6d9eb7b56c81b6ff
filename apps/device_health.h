#pragma once

#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <vector>

#include "lib/hal/tap.h"

#include "second_look/device_status_t.hpp"

namespace secondlook::apps {

/// How the devices of a tapped robot are, from what they answer alone: no device is asked for it.
/// Threading: Status() from any thread, the rest from the one that uses the robot.
class DeviceHealth : public hal::RobotListener {
 public:
  explicit DeviceHealth(const hal::Robot& robot);

  /// The base, the head, the camera and, if there are any, the arm and the hand's camera, as
  /// status_t has them, at robot time `now`.
  std::vector<second_look::device_status_t> Status(Time now) const;

  void OnBaseState(const hal::BaseState& state) override { Answered(&base_, state.time); }
  void OnBaseStatus(const hal::MotionStatus& status) override { Moved(&base_, status); }
  void OnHeadState(const hal::PanTiltState& state) override { Answered(&head_, state.time); }
  void OnHeadStatus(const hal::MotionStatus& status) override { Moved(&head_, status); }
  void OnArmState(const hal::ArmState& state) override { Answered(&*arm_, state.time); }
  void OnArmStatus(const hal::MotionStatus& status) override { Moved(&*arm_, status); }
  void OnFrame(const std::optional<hal::RgbdFrame>& frame, Time now) override;
  void OnHandFrame(const std::optional<hal::RgbdFrame>& frame, Time now) override;
  void OnError(hal::Call call, const Error& error, Time now) override;

 private:
  struct Device {
    second_look::device_status_t status;
    std::deque<Time> answers;                    ///< The newest measurements, each once.
    std::optional<std::uint64_t> last_sequence;  ///< Of a camera's frames.
  };

  static Device MakeDevice(const std::string& name, const std::string& kind);
  void Answered(Device* device, Time measured);
  void Moved(Device* device, const hal::MotionStatus& status);
  void Grabbed(Device* camera, const std::optional<hal::RgbdFrame>& frame);

  mutable std::mutex mutex_;  // of all below
  Device base_;
  Device head_;
  Device camera_;
  std::optional<Device> arm_;
  std::optional<Device> hand_camera_;
};

}  // namespace secondlook::apps
