#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "apps/real_robot.h"
#include "lib/hal/drivers/live_clock.h"
#include "sim/sim_robot.h"
#include "tests/drivers/ptu_emulator.h"
#include "tests/lcm_drivers/base_follower.h"

namespace secondlook::apps {

/// The simulated world in wall time, and in it a robot whose devices are to be had as those of a
/// real one alone: a pan-tilt unit at a serial port, a camera and a base over LCM.
class EmulatedRobot {
 public:
  /// @param link The network its devices are on. @param folder Where the serial port appears.
  /// @param frame_seconds Between two frames: each costs the time to draw it.
  EmulatedRobot(sim::SimulatedRobot simulated, std::shared_ptr<hal::LcmLink> link,
                const std::filesystem::path& folder, double frame_seconds);
  ~EmulatedRobot();

  /// What connects to it over `lcm_url`.
  RealConfig Config(const std::string& lcm_url) const;

  /// The nominal calibration of the robot.
  const kinematics::HeadCalibration& calibration() const { return simulated_.calibration; }

  hal::PtuEmulator& pan_tilt() { return pan_tilt_; }
  void SetCameraSilent(bool silent) { camera_silent_ = silent; }

  /// The number that the world's camera gave to the frame that was taken at `time`.
  std::uint64_t SequenceAt(Time time) const;

  /// Lets the world stand still from now on.
  void End();
  const sim::World& world() const { return *simulated_.world; }

 private:
  void Run();
  void StepTo(Time time);
  void Turn();
  void Send();

  sim::SimulatedRobot simulated_;
  const std::shared_ptr<hal::LcmLink> link_;
  const Duration frame_period_;
  hal::LiveClock clock_;
  const Duration ahead_;  ///< Of the world's clock by the live one.
  hal::PtuEmulator pan_tilt_;
  hal::BaseFollower base_;
  hal::PanTiltAngles target_;
  std::atomic<bool> camera_silent_{false};
  mutable std::mutex mutex_;  // of what follows
  std::vector<std::pair<Time, std::uint64_t>> sent_;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

/// `camera` with the numbers that the world gives to its frames, by which they can be judged.
class JudgedCamera : public hal::Camera {
 public:
  JudgedCamera(std::unique_ptr<hal::Camera> camera, const EmulatedRobot* robot)
      : camera_(std::move(camera)), robot_(robot) {}

  const hal::CameraInfo& info() const override { return camera_->info(); }
  std::optional<hal::RgbdFrame> Grab(Duration timeout) override {
    std::optional<hal::RgbdFrame> frame = camera_->Grab(timeout);
    if (frame) frame->sequence = robot_->SequenceAt(frame->time);
    return frame;
  }

 private:
  std::unique_ptr<hal::Camera> camera_;
  const EmulatedRobot* robot_;
};

}  // namespace secondlook::apps
