#include "lib/hal/tap.h"

#include <memory>
#include <thread>
#include <utility>

namespace secondlook::hal {
namespace {

class TappedClock : public Clock {
 public:
  TappedClock(std::unique_ptr<Clock> clock, RobotListener* listener)
      : clock_(std::move(clock)), listener_(listener) {}

  Time Now() const override {
    const Time now = clock_->Now();
    if (std::this_thread::get_id() == thread_) listener_->OnNow(now);
    return now;
  }

  void SleepUntil(Time time) override {
    clock_->SleepUntil(time);
    listener_->OnSleep(time, clock_->Now());
  }

  void ChargeThinking(Duration cost) override {
    clock_->ChargeThinking(cost);
    listener_->OnThinking(cost, clock_->Now());
  }

  /// The time without anybody being told.
  Time Peek() const { return clock_->Now(); }

 private:
  std::unique_ptr<Clock> clock_;
  RobotListener* listener_;
  std::thread::id thread_{std::this_thread::get_id()};
};

/// What tapped devices have in common: the listener, and the clock that errors are dated by.
struct Tapped {
  const TappedClock* clock;
  RobotListener* listener;

  /// What `ask` returns; an error is told before it goes on.
  template <class Ask>
  auto Answer(Call call, const Ask& ask) const try {
    return ask();
  } catch (const Error& error) {
    listener->OnError(call, error, clock->Peek());
    throw;
  }
};

class TappedBase : public Base {
 public:
  TappedBase(std::unique_ptr<Base> base, const Tapped& tapped)
      : base_(std::move(base)), tapped_(tapped) {}

  const BaseInfo& info() const override { return base_->info(); }

  BaseState State() override {
    const BaseState state = tapped_.Answer(Call::kBaseState, [&] { return base_->State(); });
    tapped_.listener->OnBaseState(state);
    return state;
  }

  void Start(const BasePath& path) override {
    tapped_.Answer(Call::kBaseStart, [&] { base_->Start(path); });
    tapped_.listener->OnBaseStart(path);
  }

  MotionStatus Status() override {
    MotionStatus status = tapped_.Answer(Call::kBaseStatus, [&] { return base_->Status(); });
    tapped_.listener->OnBaseStatus(status);
    return status;
  }

  void Stop() noexcept override { base_->Stop(); }

 private:
  std::unique_ptr<Base> base_;
  Tapped tapped_;
};

class TappedPanTilt : public PanTilt {
 public:
  TappedPanTilt(std::unique_ptr<PanTilt> head, const Tapped& tapped)
      : head_(std::move(head)), tapped_(tapped) {}

  const PanTiltInfo& info() const override { return head_->info(); }

  PanTiltState State() override {
    const PanTiltState state = tapped_.Answer(Call::kHeadState, [&] { return head_->State(); });
    tapped_.listener->OnHeadState(state);
    return state;
  }

  void Start(const PanTiltAngles& target) override {
    tapped_.Answer(Call::kHeadStart, [&] { head_->Start(target); });
    tapped_.listener->OnHeadStart(target);
  }

  MotionStatus Status() override {
    MotionStatus status = tapped_.Answer(Call::kHeadStatus, [&] { return head_->Status(); });
    tapped_.listener->OnHeadStatus(status);
    return status;
  }

  void Stop() noexcept override { head_->Stop(); }

 private:
  std::unique_ptr<PanTilt> head_;
  Tapped tapped_;
};

class TappedArm : public Arm {
 public:
  TappedArm(std::unique_ptr<Arm> arm, const Tapped& tapped)
      : arm_(std::move(arm)), tapped_(tapped) {}

  const ArmInfo& info() const override { return arm_->info(); }

  ArmState State() override {
    ArmState state = tapped_.Answer(Call::kArmState, [&] { return arm_->State(); });
    tapped_.listener->OnArmState(state);
    return state;
  }

  void Start(const JointTrajectory& trajectory) override {
    tapped_.Answer(Call::kArmStart, [&] { arm_->Start(trajectory); });
    tapped_.listener->OnArmStart(trajectory);
  }

  MotionStatus Status() override {
    MotionStatus status = tapped_.Answer(Call::kArmStatus, [&] { return arm_->Status(); });
    tapped_.listener->OnArmStatus(status);
    return status;
  }

  void Stop() noexcept override { arm_->Stop(); }

 private:
  std::unique_ptr<Arm> arm_;
  Tapped tapped_;
};

/// Which camera it is says `call`, its Grab().
class TappedCamera : public Camera {
 public:
  TappedCamera(std::unique_ptr<Camera> camera, Call call, const Tapped& tapped)
      : camera_(std::move(camera)), call_(call), tapped_(tapped) {}

  const CameraInfo& info() const override { return camera_->info(); }

  std::optional<RgbdFrame> Grab(Duration timeout) override {
    std::optional<RgbdFrame> frame = tapped_.Answer(call_, [&] { return camera_->Grab(timeout); });
    if (call_ == Call::kGrab) {
      tapped_.listener->OnFrame(frame, tapped_.clock->Peek());
    } else {
      tapped_.listener->OnHandFrame(frame, tapped_.clock->Peek());
    }
    return frame;
  }

 private:
  std::unique_ptr<Camera> camera_;
  Call call_;
  Tapped tapped_;
};

}  // namespace

Robot Tap(Robot robot, RobotListener* listener) {
  auto clock = std::make_unique<TappedClock>(std::move(robot.clock), listener);
  const Tapped tapped{clock.get(), listener};
  Robot result;
  result.clock = std::move(clock);
  result.base = std::make_unique<TappedBase>(std::move(robot.base), tapped);
  result.head = std::make_unique<TappedPanTilt>(std::move(robot.head), tapped);
  result.head_camera =
      std::make_unique<TappedCamera>(std::move(robot.head_camera), Call::kGrab, tapped);
  if (robot.arm) result.arm = std::make_unique<TappedArm>(std::move(robot.arm), tapped);
  if (robot.hand_camera) {
    result.hand_camera =
        std::make_unique<TappedCamera>(std::move(robot.hand_camera), Call::kHandGrab, tapped);
  }
  result.striper = std::move(robot.striper);
  return result;
}

}  // namespace secondlook::hal
