#include "sim/faulty_robot.h"

#include <algorithm>
#include <atomic>
#include <deque>
#include <initializer_list>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include <opencv2/core.hpp>

#include "lib/common/error.h"
#include "lib/common/hash.h"
#include "lib/common/rng.h"

namespace secondlook::sim {
namespace {

using hal::MotionPhase;
using hal::MotionStatus;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Duration kSlowPeriod = Seconds(3.0);
constexpr Duration kDelay = Seconds(0.4);
constexpr Duration kSetOut = Seconds(2.0);  // a motion ends early, or begins, after so long
constexpr Duration kClockJump = Seconds(5.0);
constexpr Duration kHalfPeriod = Seconds(1.0);  // of what is intermittent
constexpr double kDepthScale = 1.1;
constexpr double kOdometryScale = 1.1;
constexpr double kNearLimit = 0.1;  // of a joint's range
constexpr double kAngleOffset = 4.0 * std::numbers::pi / 180.0;
constexpr double kPlaceOffset = 0.3;  // [m]

/// The faults of one part, and the clock that they keep to.
class Faults {
 public:
  Faults(FaultyPart part, const std::vector<Fault>& all, const Clock* clock) : clock_(clock) {
    for (const Fault& fault : all) {
      if (fault.part == part) faults_.push_back(fault);
    }
  }

  bool Now(FaultType type) const {
    const Time now = clock_->Now();
    return std::any_of(faults_.begin(), faults_.end(), [&](const Fault& fault) {
      return fault.type == type && now >= fault.from && now < fault.until;
    });
  }

  /// @throws DeviceError naming `device` while it is off.
  void RequireOn(const std::string& device) const {
    if (Now(FaultType::kOff)) Throw<DeviceError>("{}: the device is lost (simulated)", device);
  }

  /// True in every other half period of what is intermittent.
  bool Fails() const {
    return Now(FaultType::kIntermittent) &&
           (clock_->Now().time_since_epoch() / kHalfPeriod) % 2 == 1;
  }

  const Clock& clock() const { return *clock_; }

 private:
  std::vector<Fault> faults_;
  const Clock* clock_;
};

class FaultyCamera : public hal::Camera {
 public:
  FaultyCamera(std::unique_ptr<hal::Camera> camera, Faults faults, Clock* clock, std::uint64_t seed)
      : camera_(std::move(camera)), faults_(std::move(faults)), clock_(clock), rng_(seed) {}

  const hal::CameraInfo& info() const override { return camera_->info(); }

  std::optional<hal::RgbdFrame> Grab(Duration timeout) override {
    faults_.RequireOn("camera '" + info().name + "'");
    const bool slow = faults_.Now(FaultType::kSlow) && clock_->Now() < last_ + kSlowPeriod;
    const bool silent = faults_.Now(FaultType::kIntermittent) && rng_.Uniform(0.0, 1.0) < 0.5;
    if (slow || silent) {
      clock_->SleepUntil(clock_->Now() + timeout);
      return std::nullopt;
    }
    std::optional<hal::RgbdFrame> frame = camera_->Grab(timeout);
    if (!frame) return frame;
    last_ = clock_->Now();
    Spoil(&*frame);
    return frame;
  }

 private:
  void Spoil(hal::RgbdFrame* frame) {
    if (!faults_.Now(FaultType::kStuck)) {
      shown_ = *frame;
    } else if (shown_) {
      frame->color = shown_->color;
      frame->depth = shown_->depth;
    }
    if (faults_.Now(FaultType::kDelayed)) clock_->SleepUntil(clock_->Now() + kDelay);
    if (faults_.Now(FaultType::kClockJump)) frame->time += kClockJump;
    if (faults_.Now(FaultType::kGarbage)) {
      frame->color = frame->color.clone();
      cv::RNG noise(rng_.Bits());
      noise.fill(frame->color, cv::RNG::UNIFORM, 0, 256);
    }
    if (frame->depth.empty()) return;
    if (faults_.Now(FaultType::kWrong)) frame->depth = frame->depth * kDepthScale;
    if (faults_.Now(FaultType::kBlind)) frame->depth = cv::Mat(frame->depth.size(), CV_32F, kNan);
    if (faults_.Now(FaultType::kGarbage)) {
      frame->depth = frame->depth.clone();
      cv::RNG noise(rng_.Bits());
      noise.fill(frame->depth, cv::RNG::UNIFORM, -1.0, 10.0);
      frame->depth.row(0).setTo(std::numeric_limits<float>::infinity());
    }
  }

  std::unique_ptr<hal::Camera> camera_;
  Faults faults_;
  Clock* clock_;
  Rng rng_;
  Time last_{Duration(-1'000'000'000'000)};
  std::optional<hal::RgbdFrame> shown_;  // before it was stuck
};

/// How the faults of an actuator change its motions. `Device` is any of them, `Plan` what it is
/// given.
template <class Device, class Plan>
class FaultyMotion {
 public:
  FaultyMotion(Device* device, Faults faults) : device_(device), faults_(std::move(faults)) {}

  void Start(const Plan& plan) {
    started_ = faults_.clock().Now();
    stop_requested_ = false;
    own_ = {};
    ending_.reset();
    late_since_.reset();
    waiting_.reset();
    if (faults_.Now(FaultType::kRefuses) || faults_.Fails()) {
      own_ = {MotionPhase::kFailed, "the motion is refused (simulated)"};
    } else if (faults_.Now(FaultType::kStuck)) {
      own_ = {MotionPhase::kMoving, ""};
    } else if (faults_.Now(FaultType::kDelayed)) {
      own_ = {MotionPhase::kMoving, ""};
      waiting_ = plan;
    } else {
      device_->Start(plan);
    }
  }

  MotionStatus Status() {
    const bool due = faults_.clock().Now() >= started_ + kSetOut;
    if (stop_requested_.exchange(false)) {
      waiting_.reset();
      ending_.reset();
      if (own_.phase == MotionPhase::kMoving) own_.phase = MotionPhase::kStopped;
    }
    if (waiting_ && due) {
      own_ = {};
      device_->Start(*std::exchange(waiting_, std::nullopt));
    }
    if (own_.phase != MotionPhase::kIdle) return own_;
    const MotionStatus status = device_->Status();
    if (status.phase != MotionPhase::kMoving) return Ended(status);
    if (ending_ || !due) return status;
    if (faults_.Now(FaultType::kAborts)) Fail("the motion is aborted (simulated)");
    if (faults_.Now(FaultType::kStopsShort)) EndAs({MotionPhase::kReached, ""});
    return status;
  }

  /// It brakes, and has failed for this reason once it stands.
  void Fail(const std::string& reason) { EndAs({MotionPhase::kFailed, reason}); }

  /// From any thread. What has not set out ends in Status().
  void Stop() noexcept {
    stop_requested_ = true;
    device_->Stop();
  }

 private:
  void EndAs(const MotionStatus& status) {
    if (!ending_) ending_ = status;
    device_->Stop();
  }

  /// What a motion that the device has ended with `status` says.
  MotionStatus Ended(const MotionStatus& status) {
    if (ending_ && status.phase == MotionPhase::kStopped) return own_ = *ending_;
    if (status.phase != MotionPhase::kReached || !faults_.Now(FaultType::kSlow)) return status;
    const Time now = faults_.clock().Now();
    if (!late_since_) late_since_ = now;
    if (now < *late_since_ + kSlowPeriod) return {MotionPhase::kMoving, ""};
    return status;
  }

  Device* device_;
  Faults faults_;
  Time started_{};
  std::atomic<bool> stop_requested_{false};
  MotionStatus own_;                    // instead of the device's; idle: the device's holds
  std::optional<MotionStatus> ending_;  // instead of the device's, once it stands
  std::optional<Time> late_since_;      // when the device had arrived
  std::optional<Plan> waiting_;         // to set out
};

class FaultyBase : public hal::Base {
 public:
  FaultyBase(std::unique_ptr<hal::Base> base, Faults faults, Faults localisation)
      : base_(std::move(base)),
        faults_(faults),
        localisation_(std::move(localisation)),
        motion_(base_.get(), std::move(faults)) {}

  const hal::BaseInfo& info() const override { return base_->info(); }

  hal::BaseState State() override {
    const std::string name = "base '" + info().name + "'";
    faults_.RequireOn(name);
    localisation_.RequireOn(name);
    hal::BaseState state = base_->State();
    const bool slow =
        localisation_.Now(FaultType::kSlow) && last_ && state.time < last_->time + kSlowPeriod;
    const bool frozen = localisation_.Now(FaultType::kStuck) || localisation_.Fails() || slow;
    if (!frozen) last_ = state;
    if (frozen && last_) return *last_;
    if (localisation_.Now(FaultType::kGarbage)) state.X_WB = {kNan, state.X_WB.y, 0.0};
    if (localisation_.Now(FaultType::kWrong)) state.X_WB.x += kPlaceOffset;
    if (localisation_.Now(FaultType::kClockJump)) state.time += kClockJump;
    if (faults_.Now(FaultType::kGarbage)) state.X_OB = {kNan, state.X_OB.y, 0.0};
    if (faults_.Now(FaultType::kWrong)) state.X_OB.x *= kOdometryScale;
    if (localisation_.Now(FaultType::kDelayed)) return Delayed(state);
    return state;
  }

  void Start(const hal::BasePath& path) override {
    faults_.RequireOn("base '" + info().name + "'");
    motion_.Start(path);
  }
  MotionStatus Status() override {
    faults_.RequireOn("base '" + info().name + "'");
    return motion_.Status();
  }
  void Stop() noexcept override { motion_.Stop(); }

 private:
  /// The newest state that has come in.
  hal::BaseState Delayed(const hal::BaseState& state) {
    late_.push_back(state);
    while (late_.size() > 1 && late_[1].time <= state.time - kDelay) late_.pop_front();
    return late_.front();
  }

  std::unique_ptr<hal::Base> base_;
  Faults faults_;
  Faults localisation_;
  FaultyMotion<hal::Base, hal::BasePath> motion_;
  std::optional<hal::BaseState> last_;
  std::deque<hal::BaseState> late_;
};

class FaultyPanTilt : public hal::PanTilt {
 public:
  FaultyPanTilt(std::unique_ptr<hal::PanTilt> head, Faults faults)
      : head_(std::move(head)), faults_(faults), motion_(head_.get(), std::move(faults)) {}

  const hal::PanTiltInfo& info() const override { return head_->info(); }

  hal::PanTiltState State() override {
    faults_.RequireOn("pan-tilt '" + info().name + "'");
    hal::PanTiltState state = head_->State();
    if (faults_.Now(FaultType::kGarbage)) state.angles = {kNan, kNan};
    if (faults_.Now(FaultType::kWrong)) state.angles.pan += kAngleOffset;
    if (faults_.Now(FaultType::kClockJump)) state.time += kClockJump;
    return state;
  }

  void Start(const hal::PanTiltAngles& target) override {
    faults_.RequireOn("pan-tilt '" + info().name + "'");
    motion_.Start(target);
  }
  MotionStatus Status() override {
    faults_.RequireOn("pan-tilt '" + info().name + "'");
    return motion_.Status();
  }
  void Stop() noexcept override { motion_.Stop(); }

 private:
  std::unique_ptr<hal::PanTilt> head_;
  Faults faults_;
  FaultyMotion<hal::PanTilt, hal::PanTiltAngles> motion_;
};

class FaultyArm : public hal::Arm {
 public:
  FaultyArm(std::unique_ptr<hal::Arm> arm, Faults faults)
      : arm_(std::move(arm)), faults_(faults), motion_(arm_.get(), std::move(faults)) {}

  const hal::ArmInfo& info() const override { return arm_->info(); }

  hal::ArmState State() override {
    faults_.RequireOn("arm '" + info().name + "'");
    hal::ArmState state = arm_->State();
    if (faults_.Now(FaultType::kGarbage)) state.q.setConstant(kNan);
    if (faults_.Now(FaultType::kWrong)) state.q.array() += kAngleOffset;
    if (faults_.Now(FaultType::kClockJump)) state.time += kClockJump;
    return state;
  }

  void Start(const hal::JointTrajectory& trajectory) override {
    faults_.RequireOn("arm '" + info().name + "'");
    from_ = arm_->State().q;
    motion_.Start(trajectory);
  }
  MotionStatus Status() override {
    faults_.RequireOn("arm '" + info().name + "'");
    const hal::JointInfo* joint = faults_.Now(FaultType::kAtLimit) ? NearLimit() : nullptr;
    if (joint != nullptr) {
      motion_.Fail("joint '" + joint->name + "' has come to its limit (simulated)");
    }
    return motion_.Status();
  }
  void Stop() noexcept override { motion_.Stop(); }

 private:
  /// The joint that this motion has brought nearer than it should come to its limit; null: none.
  const hal::JointInfo* NearLimit() {
    const Eigen::VectorXd q = arm_->State().q;
    for (Eigen::Index i = 0; i < from_.size(); ++i) {
      const hal::JointInfo& joint = info().joints[static_cast<std::size_t>(i)];
      const auto room = [&](double angle) {
        return std::min(angle - joint.lower, joint.upper - angle) / (joint.upper - joint.lower);
      };
      if (room(q[i]) < std::min(kNearLimit, room(from_[i]))) return &joint;
    }
    return nullptr;
  }

  std::unique_ptr<hal::Arm> arm_;
  Faults faults_;
  FaultyMotion<hal::Arm, hal::JointTrajectory> motion_;
  Eigen::VectorXd from_;  // where the last motion began
};

const char* ToString(FaultyPart part) {
  switch (part) {
    case FaultyPart::kHeadCamera:
      return "head camera";
    case FaultyPart::kHandCamera:
      return "hand camera";
    case FaultyPart::kHead:
      return "pan-tilt";
    case FaultyPart::kBase:
      return "base";
    case FaultyPart::kLocalisation:
      return "localisation";
    case FaultyPart::kArm:
      return "arm";
  }
  return "";
}

const char* ToString(FaultType type) {
  switch (type) {
    case FaultType::kOff:
      return "off";
    case FaultType::kStuck:
      return "stuck";
    case FaultType::kGarbage:
      return "garbage";
    case FaultType::kWrong:
      return "wrong";
    case FaultType::kSlow:
      return "slow";
    case FaultType::kDelayed:
      return "delayed";
    case FaultType::kIntermittent:
      return "intermittent";
    case FaultType::kBlind:
      return "blind";
    case FaultType::kClockJump:
      return "clock jump";
    case FaultType::kRefuses:
      return "refuses";
    case FaultType::kAborts:
      return "aborts";
    case FaultType::kStopsShort:
      return "stops short";
    case FaultType::kAtLimit:
      return "at a limit";
  }
  return "";
}

}  // namespace

std::vector<Fault> AllFaults(bool with_arm) {
  using enum FaultType;
  std::vector<Fault> all;
  const auto add = [&](FaultyPart part, std::initializer_list<FaultType> types) {
    for (const FaultType type : types) all.push_back({part, type});
  };
  const std::initializer_list<FaultType> camera{kOff,     kStuck,        kGarbage, kWrong,    kSlow,
                                                kDelayed, kIntermittent, kBlind,   kClockJump};
  add(FaultyPart::kHeadCamera, camera);
  const std::initializer_list<FaultType> actuator{kOff,          kStuck,     kGarbage, kWrong,
                                                  kSlow,         kDelayed,   kRefuses, kAborts,
                                                  kIntermittent, kStopsShort};
  add(FaultyPart::kHead, actuator);
  add(FaultyPart::kHead, {kClockJump});
  add(FaultyPart::kBase, actuator);
  add(FaultyPart::kLocalisation,
      {kOff, kStuck, kGarbage, kWrong, kSlow, kDelayed, kIntermittent, kClockJump});
  if (!with_arm) return all;
  add(FaultyPart::kHandCamera, camera);
  add(FaultyPart::kArm, actuator);
  add(FaultyPart::kArm, {kClockJump, kAtLimit});
  return all;
}

std::string ToString(const Fault& fault) {
  return std::string(ToString(fault.part)) + " " + ToString(fault.type);
}

hal::Robot WithFaults(hal::Robot robot, const std::vector<Fault>& faults, std::uint64_t seed) {
  Clock* clock = robot.clock.get();
  const auto of = [&](FaultyPart part) { return Faults(part, faults, clock); };
  robot.base = std::make_unique<FaultyBase>(std::move(robot.base), of(FaultyPart::kBase),
                                            of(FaultyPart::kLocalisation));
  robot.head = std::make_unique<FaultyPanTilt>(std::move(robot.head), of(FaultyPart::kHead));
  robot.head_camera =
      std::make_unique<FaultyCamera>(std::move(robot.head_camera), of(FaultyPart::kHeadCamera),
                                     clock, ForkSeed(seed, "faulty head camera"));
  if (!robot.arm) return robot;
  robot.arm = std::make_unique<FaultyArm>(std::move(robot.arm), of(FaultyPart::kArm));
  robot.hand_camera =
      std::make_unique<FaultyCamera>(std::move(robot.hand_camera), of(FaultyPart::kHandCamera),
                                     clock, ForkSeed(seed, "faulty hand camera"));
  return robot;
}

}  // namespace secondlook::sim
