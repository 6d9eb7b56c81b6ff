#include "apps/device_health.h"

#include <algorithm>

namespace secondlook::apps {
namespace {

using second_look::device_status_t;

/// The rate is that of the last seconds.
constexpr Duration kWindow = Seconds(10);
/// More answers than these tell no more about a rate.
constexpr std::size_t kMaxAnswers = 1'000;

/// Answers per second over the window that ends at `now`.
double Rate(const std::deque<Time>& answers, Time now) {
  const auto recent =
      std::count_if(answers.begin(), answers.end(), [&](Time t) { return t > now - kWindow; });
  return static_cast<double>(recent) / ToSeconds(kWindow);
}

}  // namespace

DeviceHealth::Device DeviceHealth::MakeDevice(const std::string& name, const std::string& kind) {
  Device device{};
  device.status.name = name;
  device.status.kind = kind;
  device.status.health = device_status_t::UNUSED;
  return device;
}

DeviceHealth::DeviceHealth(const hal::Robot& robot)
    : base_(MakeDevice(robot.base->info().name, "base")),
      head_(MakeDevice(robot.head->info().name, "pan_tilt")),
      camera_(MakeDevice(robot.head_camera->info().name, "camera")) {
  if (robot.arm) arm_ = MakeDevice(robot.arm->info().name, "arm");
  if (robot.hand_camera) hand_camera_ = MakeDevice(robot.hand_camera->info().name, "camera");
}

std::vector<device_status_t> DeviceHealth::Status(Time now) const {
  const std::scoped_lock lock(mutex_);
  std::vector<device_status_t> all;
  for (const Device* device : {&base_, &head_, &camera_, arm_ ? &*arm_ : nullptr,
                               hand_camera_ ? &*hand_camera_ : nullptr}) {
    if (device == nullptr) continue;
    all.push_back(device->status);
    all.back().rate = Rate(device->answers, now);
  }
  return all;
}

void DeviceHealth::Answered(Device* device, Time measured) {
  const std::scoped_lock lock(mutex_);
  device->status.health = device_status_t::OK;
  if (!device->answers.empty() && device->answers.back() == measured) return;
  device->answers.push_back(measured);
  if (device->answers.size() > kMaxAnswers) device->answers.pop_front();
}

void DeviceHealth::Moved(Device* device, const hal::MotionStatus& status) {
  if (status.phase != hal::MotionPhase::kFailed) return;
  const std::scoped_lock lock(mutex_);
  device->status.last_error = status.reason;
}

void DeviceHealth::OnFrame(const std::optional<hal::RgbdFrame>& frame, Time /*now*/) {
  Grabbed(&camera_, frame);
}

void DeviceHealth::OnHandFrame(const std::optional<hal::RgbdFrame>& frame, Time /*now*/) {
  Grabbed(&*hand_camera_, frame);
}

void DeviceHealth::Grabbed(Device* camera, const std::optional<hal::RgbdFrame>& frame) {
  if (frame) Answered(camera, frame->time);
  const std::scoped_lock lock(mutex_);
  if (!frame) {
    camera->status.health = device_status_t::SILENT;
    return;
  }
  if (camera->last_sequence) {
    camera->status.drops += static_cast<std::int64_t>(frame->sequence - *camera->last_sequence) - 1;
  }
  camera->last_sequence = frame->sequence;
}

void DeviceHealth::OnError(hal::Call call, const Error& error, Time /*now*/) {
  const std::scoped_lock lock(mutex_);
  const auto device = [&]() -> Device& {
    switch (call) {
      case hal::Call::kGrab:
        return camera_;
      case hal::Call::kHandGrab:
        return *hand_camera_;
      case hal::Call::kArmState:
      case hal::Call::kArmStart:
      case hal::Call::kArmStatus:
        return *arm_;
      case hal::Call::kHeadState:
      case hal::Call::kHeadStart:
      case hal::Call::kHeadStatus:
        return head_;
      default:
        return base_;
    }
  };
  if (dynamic_cast<const DeviceError*>(&error) != nullptr) {
    device().status.health = device_status_t::FAILED;
  }
  device().status.last_error = error.what();
}

}  // namespace secondlook::apps
