#pragma once

#include <deque>
#include <memory>
#include <string>
#include <utility>

#include "lib/common/error.h"
#include "lib/hal/robot.h"

namespace secondlook::testing {

/// What the devices of a fake robot are to do, and what was done with them. Time moves only when
/// somebody sleeps.
struct FakeWorld {
  Time now{};

  // The base is at X_WB and drives along +x with `base_speed` [m/s] while it moves.
  Pose2 X_WB;
  double base_speed{};
  hal::MotionStatus base_status;
  Duration base_takes{};  ///< From Start() until `base_ends` is its status.
  hal::MotionStatus base_ends{hal::MotionPhase::kReached, ""};
  bool base_lost_on_status{};  ///< Status() throws DeviceError from now on.
  Time base_started{};
  int base_starts{};
  int base_stops{};
  Duration state_lag{};  ///< So old are the stamps of base and head.

  // The head turns at once to where it was told, `head_takes` after Start().
  hal::PanTiltAngles angles;
  hal::PanTiltAngles target;
  double pan_speed{};  ///< Of a head that turns by itself all the time [rad/s].
  hal::MotionStatus head_status;
  Duration head_takes{};
  hal::MotionStatus head_ends{hal::MotionPhase::kReached, ""};
  bool head_lost_on_start{};
  Time head_started{};
  int head_starts{};
  int head_stops{};

  // The arm is at once where its trajectory ends, `arm_takes` after Start().
  Eigen::VectorXd q{Eigen::VectorXd::Zero(2)};
  Eigen::VectorXd arm_target;
  hal::MotionStatus arm_status;
  Duration arm_takes{};
  hal::MotionStatus arm_ends{hal::MotionPhase::kReached, ""};
  Time arm_started{};
  int arm_starts{};
  int arm_stops{};

  std::deque<hal::RgbdFrame> frames;  ///< Handed out one after the other; none when empty.
  int grabs{};

  void Advance(Duration by) {
    now += by;
    if (base_status.phase == hal::MotionPhase::kMoving) X_WB.x += base_speed * ToSeconds(by);
    angles.pan += pan_speed * ToSeconds(by);
    if (base_status.phase == hal::MotionPhase::kMoving && now >= base_started + base_takes) {
      base_status = base_ends;
    }
    if (head_status.phase == hal::MotionPhase::kMoving && now >= head_started + head_takes) {
      head_status = head_ends;
      if (head_ends.phase == hal::MotionPhase::kReached) angles = target;
    }
    if (arm_status.phase == hal::MotionPhase::kMoving && now >= arm_started + arm_takes) {
      arm_status = arm_ends;
      if (arm_ends.phase == hal::MotionPhase::kReached) q = arm_target;
    }
  }
};

class FakeClock : public Clock {
 public:
  explicit FakeClock(FakeWorld* world) : world_(world) {}
  Time Now() const override { return world_->now; }
  void SleepUntil(Time time) override {
    if (time > world_->now) world_->Advance(time - world_->now);
  }
  void ChargeThinking(Duration cost) override { world_->Advance(cost); }

 private:
  FakeWorld* world_;
};

class FakeBase : public hal::Base {
 public:
  explicit FakeBase(FakeWorld* world) : world_(world) {}
  const hal::BaseInfo& info() const override { return info_; }
  hal::BaseState State() override {
    return {world_->now - world_->state_lag, world_->X_WB, world_->X_WB, {}};
  }
  void Start(const hal::BasePath&) override {
    ++world_->base_starts;
    world_->base_started = world_->now;
    world_->base_status = {hal::MotionPhase::kMoving, ""};
  }
  hal::MotionStatus Status() override {
    if (world_->base_lost_on_status) Throw<DeviceError>("base 'wheels': the device is lost");
    return world_->base_status;
  }
  void Stop() noexcept override {
    ++world_->base_stops;
    if (world_->base_status.phase == hal::MotionPhase::kMoving) {
      world_->base_status = {hal::MotionPhase::kStopped, ""};
    }
  }

 private:
  FakeWorld* world_;
  hal::BaseInfo info_{"wheels", 0.25, 1.3, 0.5, 1.0};
};

class FakePanTilt : public hal::PanTilt {
 public:
  explicit FakePanTilt(FakeWorld* world) : world_(world) {}
  const hal::PanTiltInfo& info() const override { return info_; }
  hal::PanTiltState State() override { return {world_->now - world_->state_lag, world_->angles}; }
  void Start(const hal::PanTiltAngles& target) override {
    if (world_->head_lost_on_start) Throw<DeviceError>("pan-tilt 'neck': the device is lost");
    ++world_->head_starts;
    world_->head_started = world_->now;
    world_->target = target;
    world_->head_status = {hal::MotionPhase::kMoving, ""};
  }
  hal::MotionStatus Status() override { return world_->head_status; }
  void Stop() noexcept override {
    ++world_->head_stops;
    if (world_->head_status.phase == hal::MotionPhase::kMoving) {
      world_->head_status = {hal::MotionPhase::kStopped, ""};
    }
  }

 private:
  FakeWorld* world_;
  hal::PanTiltInfo info_{"neck", {-2.0, -1.0}, {2.0, 1.0}, 1.0};
};

class FakeCamera : public hal::Camera {
 public:
  explicit FakeCamera(FakeWorld* world) : world_(world) {}
  const hal::CameraInfo& info() const override { return info_; }
  std::optional<hal::RgbdFrame> Grab(Duration timeout) override {
    ++world_->grabs;
    if (world_->frames.empty()) {
      world_->Advance(timeout);
      return std::nullopt;
    }
    hal::RgbdFrame frame = world_->frames.front();
    world_->frames.pop_front();
    return frame;
  }

 private:
  FakeWorld* world_;
  hal::CameraInfo info_{"eye", {64, 48, 60.0, 60.0, 31.5, 23.5}, true, 0.5, 6.0};
};

class FakeArm : public hal::Arm {
 public:
  explicit FakeArm(FakeWorld* world) : world_(world) {}
  const hal::ArmInfo& info() const override { return info_; }
  hal::ArmState State() override { return {world_->now - world_->state_lag, world_->q}; }
  void Start(const hal::JointTrajectory& trajectory) override {
    ++world_->arm_starts;
    world_->arm_started = world_->now;
    world_->arm_target = trajectory.knots.back().q;
    world_->arm_status = {hal::MotionPhase::kMoving, ""};
  }
  hal::MotionStatus Status() override { return world_->arm_status; }
  void Stop() noexcept override {
    ++world_->arm_stops;
    if (world_->arm_status.phase == hal::MotionPhase::kMoving) {
      world_->arm_status = {hal::MotionPhase::kStopped, ""};
    }
  }

 private:
  FakeWorld* world_;
  hal::ArmInfo info_{"limb", {{"lift", -2.0, 2.0, 1.0, 2.0}, {"bend", -2.0, 2.0, 1.0, 2.0}}};
};

/// A robot whose devices do what `world`, which must outlive it, says.
inline hal::Robot MakeFakeRobot(FakeWorld* world) {
  hal::Robot robot;
  robot.clock = std::make_unique<FakeClock>(world);
  robot.base = std::make_unique<FakeBase>(world);
  robot.head = std::make_unique<FakePanTilt>(world);
  robot.head_camera = std::make_unique<FakeCamera>(world);
  return robot;
}

/// The same with an arm of two joints and a camera in its hand, which shares the frames.
inline hal::Robot MakeFakeRobotWithArm(FakeWorld* world) {
  hal::Robot robot = MakeFakeRobot(world);
  robot.arm = std::make_unique<FakeArm>(world);
  robot.hand_camera = std::make_unique<FakeCamera>(world);
  return robot;
}

}  // namespace secondlook::testing
