#include "lib/hal/drivers/kuka_iiwa.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/hal/drivers/sender_time.h"

#include "drake/lcmt_iiwa_command.hpp"
#include "drake/lcmt_iiwa_status.hpp"

namespace secondlook::hal {
namespace {

using drake::lcmt_iiwa_command;
using drake::lcmt_iiwa_status;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kCommand = "IIWA_COMMAND";
constexpr const char* kStatus = "IIWA_STATUS";
constexpr std::size_t kJoints = 7;
constexpr double kLongestBeat = 0.02;        // [s] of the trajectory between two statuses
constexpr double kReached = 0.25 * kDegree;  // half of what Arm::Status() allows
constexpr double kStill = 0.1 * kDegree;     // [rad/s]
constexpr double kSettles = 1.0;             // [s] that it may take to arrive after its command
constexpr int kQueue = 10;

}  // namespace

/// Answers each status. Threading: Receive() from the link's thread, the rest from any.
class KukaIiwa::Servo {
 public:
  Servo(const KukaIiwaConfig& config, const ArmInfo& info, LcmLink* link, const Clock* clock)
      : info_(info),
        link_(link),
        clock_(clock),
        patience_(Seconds(config.patience_seconds)),
        max_lag_(config.max_lag_deg * kDegree) {}

  /// @throws ProtocolError for a status that is not this arm's.
  void Receive(const transport::Message& message) {
    const Time now = clock_->Now();
    const auto status = transport::Decode<lcmt_iiwa_status>(message);
    if (status.num_joints != static_cast<std::int32_t>(info_.joints.size())) {
      Throw<ProtocolError>("a status of {} joints, and it has {}: is it another arm's?",
                           status.num_joints, info_.joints.size());
    }
    std::optional<Eigen::VectorXd> command;
    {
      const std::scoped_lock lock(mutex_);
      Measure(now, Eigen::Map<const Eigen::VectorXd>(status.joint_position_measured.data(),
                                                     status.num_joints));
      command = held_;
      came_.notify_all();
    }
    if (command) Command(now, *command);
  }

  void Reject(const std::string& why) {
    const std::scoped_lock lock(mutex_);
    fault_ = why;
  }

  void WaitForState(Duration timeout) {
    std::unique_lock lock(mutex_);
    came_.wait_for(lock, timeout, [&] { return state_.has_value(); });
  }

  ArmState State() {
    const std::scoped_lock lock(mutex_);
    RequireFresh();
    return *state_;
  }

  void Start(const JointTrajectory& trajectory) {
    const std::scoped_lock lock(mutex_);
    RequireFresh();
    if (status_.phase == MotionPhase::kMoving) {
      Throw<InvalidArgument>("arm '{}' is moving; stop it before it gets another trajectory",
                             info_.name);
    }
    CheckTrajectory(trajectory, info_.name, info_.joints, state_->q);
    motion_ = Motion{trajectory, state_->q - trajectory.knots.front().q};
    held_ = state_->q;  // the first command is where it is
    status_ = {MotionPhase::kMoving, ""};
  }

  MotionStatus Status() {
    const std::scoped_lock lock(mutex_);
    if (status_.phase == MotionPhase::kMoving && IsStale()) End(MotionPhase::kFailed, Lost());
    return status_;
  }

  void Stop() {
    const std::scoped_lock lock(mutex_);
    if (status_.phase == MotionPhase::kMoving) motion_.stopping = true;
  }

  /// Brakes, and commands nothing any more once it stands or `timeout` (of the machine) is over.
  void Leave(Duration timeout) {
    std::unique_lock lock(mutex_);
    motion_.stopping = true;
    came_.wait_for(lock, timeout, [&] { return status_.phase != MotionPhase::kMoving; });
    held_.reset();
    End(MotionPhase::kStopped, "");
  }

 private:
  struct Motion {
    JointTrajectory trajectory;
    Eigen::VectorXd offset;  // from where it begins to where the arm was then
    double along{};          // [s] on the trajectory
    double rate{1.0};        // of that clock; below 1 when it brakes
    double brake_seconds{};  // that braking takes; 0: it does not brake
    double waited{};         // [s] since all was commanded
    bool stopping{};
  };

  // What follows has mutex_ held.

  bool IsStale() const { return !state_ || clock_->Now() - state_->time > patience_; }

  void RequireFresh() const {
    if (IsStale()) throw DeviceError(Lost());
  }

  std::string Lost() const {
    if (!fault_.empty()) return fmt::format("arm '{}': {}: {}", info_.name, kStatus, fault_);
    return fmt::format(
        "arm '{}': no status on {} of {} for {} s: is drake-iiwa-driver running, and the arm's own "
        "program?",
        info_.name, kStatus, link_->url(), ToSeconds(patience_));
  }

  /// Takes in where the arm is, and leads it on.
  void Measure(Time now, const Eigen::VectorXd& q) {
    const double beat = state_ ? ToSeconds(now - state_->time) : 0.0;
    const bool late = state_ && now - state_->time > patience_;
    const Eigen::VectorXd before = state_ ? state_->q : q;
    state_ = ArmState{now, q};
    fault_.clear();
    if (status_.phase != MotionPhase::kMoving) return;
    if (late) {
      End(MotionPhase::kFailed, fmt::format("arm '{}': no status for {:.3f} s on its way; it is "
                                            "held where it is",
                                            info_.name, beat));
      held_ = q;
      return;
    }
    if (HeldUp(q)) return;
    const double v = beat > 0.0 ? (q - before).cwiseAbs().maxCoeff() / beat : 0.0;
    Lead(std::min(beat, kLongestBeat));
    Judge(q, v < kStill, beat);
  }

  /// Ends the motion when a joint is too far behind its command: something is in its way.
  bool HeldUp(const Eigen::VectorXd& q) {
    Eigen::Index joint = 0;
    const double lag = (q - *held_).cwiseAbs().maxCoeff(&joint);
    if (lag <= max_lag_) return false;
    End(MotionPhase::kFailed,
        fmt::format("arm '{}': {} is {:.1f} deg from where it was told to be: is something in its "
                    "way, or are its brakes on?",
                    info_.name, info_.joints[static_cast<std::size_t>(joint)].name, lag / kDegree));
    held_ = q;
    return true;
  }

  void Lead(double beat) {
    Motion& m = motion_;
    if (m.stopping && m.brake_seconds == 0.0) {
      // So long that no joint brakes harder than it may.
      const Eigen::VectorXd v = Sample(m.trajectory, m.along).v;
      m.brake_seconds = kLongestBeat;
      for (Eigen::Index i = 0; i < v.size(); ++i) {
        const double most = info_.joints[static_cast<std::size_t>(i)].acceleration;
        m.brake_seconds = std::max(m.brake_seconds, std::abs(v[i]) / most);
      }
    }
    if (m.brake_seconds > 0.0) m.rate = std::max(0.0, m.rate - beat / m.brake_seconds);
    m.along += m.rate * beat;
    // It begins up to a degree beside its trajectory, and is on it at the end.
    const double length = m.trajectory.seconds();
    const double off = length > 0.0 ? std::max(0.0, 1.0 - m.along / length) : 1.0;
    held_ = Sample(m.trajectory, m.along).q + off * m.offset;
  }

  void Judge(const Eigen::VectorXd& q, bool still, double beat) {
    Motion& m = motion_;
    const bool braked = m.stopping && m.rate == 0.0;
    if (!braked && m.along < m.trajectory.seconds()) return;
    m.waited += beat;
    const double off = (q - m.trajectory.knots.back().q).cwiseAbs().maxCoeff();
    if (braked && still) {
      End(MotionPhase::kStopped, "");
    } else if (!braked && still && off < kReached + m.offset.cwiseAbs().maxCoeff() * IsPoint()) {
      End(MotionPhase::kReached, "");
    } else if (m.waited > kSettles) {
      End(MotionPhase::kFailed,
          fmt::format("arm '{}': is {:.2f} deg from the end of its trajectory {} s after that",
                      info_.name, off / kDegree, kSettles));
    }
  }

  /// 1 for a trajectory of one knot, which is reached where it is.
  double IsPoint() const { return motion_.trajectory.seconds() > 0.0 ? 0.0 : 1.0; }

  void End(MotionPhase phase, const std::string& reason) {
    if (status_.phase == MotionPhase::kMoving) status_ = {phase, reason};
  }

  // Without mutex_ from here.

  void Command(Time now, const Eigen::VectorXd& q) {
    lcmt_iiwa_command command{};
    command.utime = Microseconds(now);
    command.num_joints = static_cast<std::int32_t>(q.size());
    command.joint_position.assign(q.data(), q.data() + q.size());
    link_->Publish({kCommand, command.utime, transport::Encode(command)});
  }

  const ArmInfo info_;
  LcmLink* const link_;
  const Clock* clock_;
  const Duration patience_;
  const double max_lag_;

  mutable std::mutex mutex_;  // of what follows
  std::condition_variable came_;
  std::optional<ArmState> state_;
  std::optional<Eigen::VectorXd> held_;  // what is commanded; empty: nothing is
  Motion motion_;
  MotionStatus status_;
  std::string fault_;
};

void KukaIiwaConfig::Validate() const {
  if (name.empty()) Throw<ConfigError>("'name' is empty: messages call the arm by it");
  for (const auto& [values, key] :
       {std::pair(&limit_deg, "limit_deg"), std::pair(&speed_deg, "speed_deg")}) {
    if (values->size() != kJoints) {
      Throw<ConfigError>("'{}' has {} values; an iiwa has {} joints", key, values->size(), kJoints);
    }
    for (const double value : *values) CheckRange(value, 0.1, 360.0, std::string("'") + key + "'");
  }
  CheckRange(acceleration_deg, 1.0, 2000.0, "'acceleration_deg'");
  CheckRange(patience_seconds, 0.02, 1.0, "'patience_seconds'");
  CheckRange(max_lag_deg, 0.5, 30.0, "'max_lag_deg'");
}

KukaIiwa::KukaIiwa(const KukaIiwaConfig& config, std::shared_ptr<LcmLink> link, const Clock* clock)
    : link_(std::move(link)) {
  config.Validate();
  info_.name = config.name;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double limit = config.limit_deg[i] * kDegree;
    info_.joints.push_back({fmt::format("joint_{}", i + 1), -limit, limit,
                            config.speed_deg[i] * kDegree, config.acceleration_deg * kDegree});
  }
  servo_ = std::make_shared<Servo>(config, info_, link_.get(), clock);
  transport::Intake intake{"drake.lcmt_iiwa_status", {}, kQueue};
  intake.limits.values = 32;
  intake.on_reject = [servo = servo_](const std::string& why) { servo->Reject(why); };
  link_->Listen(kStatus, std::move(intake),
                [servo = servo_](const auto& message) { servo->Receive(message); });
  servo_->WaitForState(Seconds(1.0));
  static_cast<void>(State());  // throws unless it has one
}

KukaIiwa::~KukaIiwa() { servo_->Leave(Seconds(1.0)); }

ArmState KukaIiwa::State() { return servo_->State(); }

void KukaIiwa::Start(const JointTrajectory& trajectory) { servo_->Start(trajectory); }

MotionStatus KukaIiwa::Status() { return servo_->Status(); }

void KukaIiwa::Stop() noexcept { servo_->Stop(); }

}  // namespace secondlook::hal
