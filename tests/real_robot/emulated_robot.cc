#include "tests/real_robot/emulated_robot.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "tests/lcm_drivers/lcm_camera_emulator.h"

namespace secondlook::apps {
namespace {

constexpr Duration kTick = Seconds(0.02);

}  // namespace

EmulatedRobot::EmulatedRobot(sim::SimulatedRobot simulated, std::shared_ptr<hal::LcmLink> link,
                             const std::filesystem::path& folder, double frame_seconds)
    : simulated_(std::move(simulated)),
      link_(std::move(link)),
      frame_period_(Seconds(frame_seconds)),
      ahead_(clock_.Now() - simulated_.world->Now()),
      pan_tilt_(static_cast<const Clock*>(&clock_), folder),
      base_(link_.get(), simulated_.robot.base.get(), simulated_.robot.clock.get(), ahead_) {
  thread_ = std::thread([this] { Run(); });
}

EmulatedRobot::~EmulatedRobot() { End(); }

void EmulatedRobot::End() {
  quit_ = true;
  if (thread_.joinable()) thread_.join();
}

RealConfig EmulatedRobot::Config(const std::string& lcm_url) const {
  const hal::CameraInfo& seen = simulated_.robot.head_camera->info();
  const hal::BaseInfo& driven = simulated_.robot.base->info();
  hal::LcmCameraConfig camera;
  camera.intrinsics = {seen.model.fx, seen.model.fy, seen.model.cx, seen.model.cy};
  camera.min_depth = seen.min_depth;
  camera.max_depth = seen.max_depth;
  camera.patience_seconds = 5.0;  // the machine may be busy with other tests
  hal::LcmBaseConfig base;
  base.radius = driven.radius;
  base.height = driven.height;
  base.speed = driven.speed;
  base.turn_rate_deg = driven.turn_rate * 180.0 / M_PI;
  base.patience_seconds = 5.0;
  hal::FlirPtuConfig pan_tilt;
  pan_tilt.device = pan_tilt_.port();
  RealConfig config;
  config.camera = camera;
  config.pan_tilt = pan_tilt;
  config.base = base;
  config.lcm_url = lcm_url;
  return config;
}

std::uint64_t EmulatedRobot::SequenceAt(Time time) const {
  const std::scoped_lock lock(mutex_);
  // Messages have microseconds.
  const auto found =
      std::min_element(sent_.begin(), sent_.end(), [&](const auto& a, const auto& b) {
        return std::chrono::abs(a.first - time) < std::chrono::abs(b.first - time);
      });
  return found == sent_.end() ? 0 : found->second;
}

void EmulatedRobot::Run() {
  Time next_frame = clock_.Now();
  while (!quit_) {
    std::this_thread::sleep_for(kTick);
    StepTo(clock_.Now() - ahead_);
    base_.Step();
    if (clock_.Now() < next_frame) continue;
    next_frame = clock_.Now() + frame_period_;
    if (!camera_silent_) Send();
  }
}

/// Steps the world, whose head follows the pan-tilt unit's orders, and the unit its encoders.
void EmulatedRobot::StepTo(Time time) {
  while (simulated_.world->Now() < time) {
    Turn();
    simulated_.world->Step();
  }
  pan_tilt_.Place(simulated_.robot.head->State().angles);
}

void EmulatedRobot::Turn() {
  const hal::PanTiltAngles target = pan_tilt_.target();
  if (target == target_) return;
  target_ = target;
  // The unit's limits are its own: the world's head turns as far as it can.
  const hal::PanTiltInfo& info = simulated_.robot.head->info();
  simulated_.robot.head->Start({std::clamp(target.pan, info.lower.pan, info.upper.pan),
                                std::clamp(target.tilt, info.lower.tilt, info.upper.tilt)});
}

void EmulatedRobot::Send() {
  std::optional<hal::RgbdFrame> frame = simulated_.robot.head_camera->Grab(Duration::zero());
  if (!frame) return;
  frame->time += ahead_;
  {
    const std::scoped_lock lock(mutex_);
    sent_.emplace_back(frame->time, frame->sequence);
  }
  link_->Publish(transport::Pack("CAMERA", hal::WriteImages(*frame)));
}

}  // namespace secondlook::apps
