#include "lib/hal/guard.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <utility>

#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
/// A base may be so far out of its workspace by the errors of localisation and of stopping [m].
constexpr double kOutside = 0.1;
/// An arm likewise, by the errors of its encoders and of following a trajectory [m].
constexpr double kArmOutside = 0.02;
/// Trajectories of an arm are tested as often as this [s]: at 90 degrees a second, 1 m away,
/// nothing is farther out between two tests than 8 mm, and planning keeps more distance than that.
constexpr double kTrajectoryStep = 0.01;
constexpr double kMaxTests = 20'000.0;  // whatever it takes
/// Speed is measured over so long a time, to odometry that comes in steps.
constexpr Duration kSpeedWindow = Seconds(0.5);
constexpr double kRounding = 1e-6;  // [m]
/// A base that is so much faster than it may be is stopped: a share, and [m/s].
constexpr double kFaster = 1.2;
constexpr double kFasterBy = 0.05;

void RequireSpeed(const char* name, double value) {
  if (value >= 0.0 && std::isfinite(value)) return;
  Throw<ConfigError>("{} = {} must be at least 0 (0: no limit but the device's own)", name, value);
}

void RequireOrdered(const char* name, const Eigen::Vector2d& range) {
  if (range.allFinite() && range[0] < range[1]) return;
  Throw<ConfigError>("{} = [{}, {}] must be [from, to], finite, with from < to", name, range[0],
                     range[1]);
}

/// @throws ConfigError when a device that goes at `speed` may go at `limit` at most (0: any).
void RequireSlow(const std::string& device, double speed, double limit, const char* unit,
                 const char* key) {
  if (limit == 0.0 || speed <= limit * (1.0 + 1e-9)) return;
  Throw<ConfigError>(
      "{} goes at {:.3g} {}, and safety.limits.{} allows {:.3g}: lower the speed in the "
      "configuration of its driver",
      device, speed, unit, key, limit);
}

/// @throws ProtocolError when what `device` says of itself is not `finite`.
void RequireFinite(bool finite, const std::string& device, const char* what) {
  if (finite) return;
  Throw<ProtocolError>("{}: {} not finite; check what measures it", device, what);
}

/// What all guarded actuators have in common: what keeps a motion from being begun, and how the
/// last one went.
class Gate {
 public:
  Gate(const Guard* guard, const Clock* clock, GuardedMotion* motion)
      : guard_(guard), clock_(clock), motion_(motion) {}

  /// Begins a motion by `start`, unless a stop holds or `refusal` says why not. A stop that comes
  /// meanwhile is not lost: whoever holds stops the device after that, or `stop` does here.
  template <class Start, class Stop>
  void Begin(std::string refusal, const Start& start, const Stop& stop) {
    ended_.reset();
    if (guard_->holds()) {
      ended_ = {MotionPhase::kStopped, "a protective stop holds: " + guard_->why()};
      return;
    }
    if (!refusal.empty()) {
      ended_ = {MotionPhase::kFailed, std::move(refusal)};
      return;
    }
    motion_->renewed = clock_->Now().time_since_epoch().count();
    start();
    motion_->moving = true;
    if (guard_->holds()) stop();
  }

  /// How far the motion is, by what `ask` says.
  template <class Ask>
  MotionStatus Answer(const Ask& ask) {
    if (ended_) return *ended_;
    motion_->renewed = clock_->Now().time_since_epoch().count();
    MotionStatus status = ask();
    motion_->moving = status.phase == MotionPhase::kMoving;
    return status;
  }

 private:
  const Guard* guard_;
  const Clock* clock_;
  GuardedMotion* motion_;
  std::optional<MotionStatus> ended_;  // of a motion that was refused
};

class GuardedBase : public Base {
 public:
  GuardedBase(std::unique_ptr<Base> base, const Guard* guard, Gate gate)
      : base_(std::move(base)), config_(guard->config()), gate_(std::move(gate)) {}

  const BaseInfo& info() const override { return base_->info(); }

  BaseState State() override {
    const BaseState state = base_->State();
    const auto finite = [](const Pose2& pose) {
      return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw);
    };
    RequireFinite(finite(state.X_WB) && finite(state.X_OB), "base '" + info().name + "'",
                  "its pose is");
    return state;
  }

  void Start(const BasePath& path) override {
    broken_.clear();
    driven_.clear();
    gate_.Begin(
        Refusal(path), [&] { base_->Start(path); }, [&] { base_->Stop(); });
  }

  /// A limit that was broken is the reason, once the base stands.
  MotionStatus Status() override {
    MotionStatus status = gate_.Answer([&] { return base_->Status(); });
    if (status.phase == MotionPhase::kMoving && broken_.empty()) {
      broken_ = Broken(State());
      if (!broken_.empty()) base_->Stop();
    }
    if (broken_.empty() || status.phase == MotionPhase::kMoving) return status;
    return {MotionPhase::kFailed, broken_};
  }

  void Stop() noexcept override { base_->Stop(); }

 private:
  std::string Refusal(const BasePath& path) {
    if (!config_.workspace) return "";
    const Workspace& space = *config_.workspace;
    const auto out = [&](const Pose2& pose) {
      const bool finite = std::isfinite(pose.x) && std::isfinite(pose.y);
      return finite && !space.Contains(pose.x, pose.y);  // what is not finite the base refuses
    };
    const auto waypoint = std::find_if(path.waypoints_W.begin(), path.waypoints_W.end(), out);
    if (waypoint == path.waypoints_W.end()) return "";
    return fmt::format("its way leads through ({:.2f}, {:.2f}) m, out of safety.limits.workspace",
                       waypoint->x, waypoint->y);
  }

  /// Which limit the base breaks in `state`; empty: none.
  std::string Broken(const BaseState& state) {
    if (config_.workspace) {
      const Workspace& space = *config_.workspace;
      const Pose2& X_WB = state.X_WB;
      const double outside = std::hypot(X_WB.x - std::clamp(X_WB.x, space.x[0], space.x[1]),
                                        X_WB.y - std::clamp(X_WB.y, space.y[0], space.y[1]));
      if (!(outside <= kOutside)) {
        return fmt::format("it is at ({:.2f}, {:.2f}) m, {:.2f} m out of safety.limits.workspace",
                           X_WB.x, X_WB.y, outside);
      }
    }
    return TooFast(state);
  }

  std::string TooFast(const BaseState& state) {
    if (config_.base_speed == 0.0) return "";
    if (!driven_.empty() && state.time <= driven_.back().time) return "";
    driven_.push_back(state);
    while (driven_.size() > 2 && driven_[1].time <= state.time - kSpeedWindow) driven_.pop_front();
    const BaseState& first = driven_.front();
    if (state.time - first.time < kSpeedWindow) return "";
    const double metres = std::hypot(state.X_OB.x - first.X_OB.x, state.X_OB.y - first.X_OB.y);
    const double speed = metres / ToSeconds(state.time - first.time);
    if (speed <= kFaster * config_.base_speed + kFasterBy) return "";
    return fmt::format("it drives at {:.2f} m/s, and safety.limits.base_speed allows {:.2f}", speed,
                       config_.base_speed);
  }

  std::unique_ptr<Base> base_;
  const GuardConfig config_;
  Gate gate_;
  std::string broken_;            // by the last motion
  std::deque<BaseState> driven_;  // the newest of it, by time
};

class GuardedPanTilt : public PanTilt {
 public:
  GuardedPanTilt(std::unique_ptr<PanTilt> head, Gate gate)
      : head_(std::move(head)), gate_(std::move(gate)) {}

  const PanTiltInfo& info() const override { return head_->info(); }
  PanTiltState State() override {
    const PanTiltState state = head_->State();
    RequireFinite(std::isfinite(state.angles.pan) && std::isfinite(state.angles.tilt),
                  "pan-tilt '" + info().name + "'", "its angles are");
    return state;
  }
  void Start(const PanTiltAngles& target) override {
    gate_.Begin(
        "", [&] { head_->Start(target); }, [&] { head_->Stop(); });
  }
  MotionStatus Status() override {
    return gate_.Answer([&] { return head_->Status(); });
  }
  void Stop() noexcept override { head_->Stop(); }

 private:
  std::unique_ptr<PanTilt> head_;
  Gate gate_;
};

/// How far the box `inner` reaches out of `outer` [m], along the axis where it is farthest; 0 or
/// less when it does not.
double Outside(const Eigen::AlignedBox3d& inner, const Eigen::AlignedBox3d& outer) {
  return std::max((outer.min() - inner.min()).maxCoeff(), (inner.max() - outer.max()).maxCoeff());
}

std::string ToText(const Eigen::AlignedBox3d& box) {
  return fmt::format("from ({:.2f}, {:.2f}, {:.2f}) to ({:.2f}, {:.2f}, {:.2f}) m in B",
                     box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(),
                     box.max().z());
}

class GuardedArm : public Arm {
 public:
  GuardedArm(std::unique_ptr<Arm> arm, const Guard* guard, ArmBox box, Gate gate)
      : arm_(std::move(arm)),
        workspace_(guard->config().arm_workspace),
        box_(std::move(box)),
        gate_(std::move(gate)) {}

  const ArmInfo& info() const override { return arm_->info(); }
  ArmState State() override {
    ArmState state = arm_->State();
    const bool whole = state.q.size() == std::ssize(info().joints);
    RequireFinite(whole && state.q.allFinite(), "arm '" + info().name + "'",
                  "its joint angles are missing or");
    return state;
  }
  void Start(const JointTrajectory& trajectory) override {
    broken_.clear();
    gate_.Begin(
        Refusal(trajectory), [&] { arm_->Start(trajectory); }, [&] { arm_->Stop(); });
  }

  /// A limit that was broken is the reason, once the arm stands.
  MotionStatus Status() override {
    MotionStatus status = gate_.Answer([&] { return arm_->Status(); });
    if (workspace_ && status.phase == MotionPhase::kMoving && broken_.empty()) {
      const Eigen::AlignedBox3d box_B = box_(State().q);
      const double outside = Outside(box_B, workspace_->box_B());
      if (!(outside <= allowed_)) {
        broken_ = fmt::format("it reaches {}, {:.2f} m out of safety.limits.arm_workspace",
                              ToText(box_B), outside);
        arm_->Stop();
      }
    }
    if (broken_.empty() || status.phase == MotionPhase::kMoving) return status;
    return {MotionPhase::kFailed, broken_};
  }

  void Stop() noexcept override { arm_->Stop(); }

 private:
  /// Where `trajectory` leaves the workspace; empty: nowhere. Whoever is out of it may come back.
  std::string Refusal(const JointTrajectory& trajectory) {
    if (!workspace_ || trajectory.knots.empty()) return "";
    const double duration = trajectory.seconds();
    if (!std::isfinite(duration)) return "";  // no motion of this arm: it refuses that itself
    const int count =
        static_cast<int>(std::clamp(std::ceil(duration / kTrajectoryStep), 1.0, kMaxTests));
    double first = 0.0;
    double worst = 0.0;
    double worst_at = 0.0;
    for (int i = 0; i <= count; ++i) {
      const double seconds = duration * i / count;
      const JointKnot knot = Sample(trajectory, seconds);
      if (knot.q.size() != std::ssize(info().joints) || !knot.q.allFinite()) return "";
      const double outside = Outside(box_(knot.q), workspace_->box_B());
      if (i == 0) first = std::max(0.0, outside);
      if (outside <= worst) continue;
      worst = outside;
      worst_at = seconds;
    }
    allowed_ = first + kArmOutside;
    if (worst <= first + kRounding) return "";
    return fmt::format(
        "its way leads out of safety.limits.arm_workspace: after {:.2f} s it reaches {}, {:.2f} m "
        "too far",
        worst_at, ToText(box_(Sample(trajectory, worst_at).q)), worst);
  }

  std::unique_ptr<Arm> arm_;
  const std::optional<ArmWorkspace> workspace_;
  const ArmBox box_;
  Gate gate_;
  double allowed_{};    // out of the workspace, in the last motion [m]
  std::string broken_;  // by it
};

/// Stays dark while a protective stop holds.
class GuardedStriper : public LaserStriper {
 public:
  GuardedStriper(std::unique_ptr<LaserStriper> striper, const Guard* guard)
      : striper_(std::move(striper)), guard_(guard) {}

  const StriperInfo& info() const override { return striper_->info(); }
  void On() override {
    if (guard_->holds()) return;
    striper_->On();
    if (guard_->holds()) striper_->Off();
  }
  void Off() noexcept override { striper_->Off(); }
  std::vector<ScanLine> Take() override { return striper_->Take(); }
  std::uint64_t lost() const override { return striper_->lost(); }

 private:
  std::unique_ptr<LaserStriper> striper_;
  const Guard* guard_;
};

}  // namespace

void Workspace::Validate() const {
  RequireOrdered("x", x);
  RequireOrdered("y", y);
}

void ArmWorkspace::Validate() const {
  RequireOrdered("x", x);
  RequireOrdered("y", y);
  RequireOrdered("z", z);
}

void GuardConfig::Validate() const {
  RequireSpeed("base_speed", base_speed);
  RequireSpeed("base_turn_rate_deg", base_turn_rate_deg);
  RequireSpeed("head_speed_deg", head_speed_deg);
  RequireSpeed("arm_speed_deg", arm_speed_deg);
  if (workspace) workspace->Validate();
  if (arm_workspace) arm_workspace->Validate();
  if (!(lapse_seconds >= 0.2 && lapse_seconds <= 60.0)) {
    Throw<ConfigError>("lapse_seconds = {} must be 0.2 to 60", lapse_seconds);
  }
}

Guard::Guard(const GuardConfig& config) : config_(config) { config_.Validate(); }

Robot Guard::Protect(Robot robot, const ArmBox& arm_box) {
  const BaseInfo& base = robot.base->info();
  const PanTiltInfo& head = robot.head->info();
  const std::string base_name = "base '" + base.name + "'";
  RequireSlow(base_name, base.speed, config_.base_speed, "m/s", "base_speed");
  RequireSlow(base_name, base.turn_rate * kDegrees, config_.base_turn_rate_deg, "deg/s",
              "base_turn_rate_deg");
  RequireSlow("pan-tilt '" + head.name + "'", head.speed * kDegrees, config_.head_speed_deg,
              "deg/s", "head_speed_deg");
  if (robot.arm) {
    for (const JointInfo& joint : robot.arm->info().joints) {
      RequireSlow("arm '" + robot.arm->info().name + "', joint '" + joint.name + "',",
                  joint.speed * kDegrees, config_.arm_speed_deg, "deg/s", "arm_speed_deg");
    }
  }
  if (config_.arm_workspace && !(robot.arm && arm_box)) {
    Throw<ConfigError>(
        "safety.limits.arm_workspace is given, but the robot has no arm whose shape is known: "
        "leave "
        "it out, or configure the arm with its urdf");
  }
  clock_ = robot.clock.get();
  const auto gate = [&](const std::string& device) {
    motions_.push_back(std::make_unique<GuardedMotion>());
    motions_.back()->device = device;
    return Gate(this, clock_, motions_.back().get());
  };
  Gate base_gate = gate(base_name);
  Gate head_gate = gate("pan-tilt '" + head.name + "'");
  robot.base = std::make_unique<GuardedBase>(std::move(robot.base), this, std::move(base_gate));
  robot.head = std::make_unique<GuardedPanTilt>(std::move(robot.head), std::move(head_gate));
  if (robot.arm) {
    Gate arm_gate = gate("arm '" + robot.arm->info().name + "'");
    robot.arm =
        std::make_unique<GuardedArm>(std::move(robot.arm), this, arm_box, std::move(arm_gate));
  }
  if (robot.striper) {
    robot.striper = std::make_unique<GuardedStriper>(std::move(robot.striper), this);
  }
  return robot;
}

void Guard::Hold(const std::string& why) {
  const std::scoped_lock lock(mutex_);
  if (!holds_) why_ = why;
  holds_ = true;
}

void Guard::Clear() {
  const std::scoped_lock lock(mutex_);
  holds_ = false;
  why_.clear();
}

std::string Guard::why() const {
  const std::scoped_lock lock(mutex_);
  return why_;
}

std::string Guard::Lapsed() const {
  if (clock_ == nullptr) return "";
  // The present first: what is renewed meanwhile has not lapsed.
  const Time::rep now = clock_->Now().time_since_epoch().count();
  const Time::rep limit = Seconds(config_.lapse_seconds).count();
  for (const auto& motion : motions_) {
    if (motion->moving && now - motion->renewed > limit) return motion->device;
  }
  return "";
}

}  // namespace secondlook::hal
