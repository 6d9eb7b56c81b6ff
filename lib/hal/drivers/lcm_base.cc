#include "lib/hal/drivers/lcm_base.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/hal/drivers/base_path.h"
#include "lib/hal/drivers/sender_time.h"
#include "lib/transport/channels.h"

#include "second_look/base_cancel_t.hpp"
#include "second_look/base_goal_t.hpp"
#include "second_look/base_pose_t.hpp"
#include "second_look/base_status_t.hpp"

namespace secondlook::hal {
namespace {

using second_look::base_cancel_t;
using second_look::base_goal_t;
using second_look::base_pose_t;
using second_look::base_status_t;

constexpr double kDegree = std::numbers::pi / 180.0;

Pose2 PoseOf(const double (&values)[3]) { return {values[0], values[1], WrapAngle(values[2])}; }

}  // namespace

/// Takes what comes in and keeps the newest. Threading: any.
class LcmBase::Inbox {
 public:
  Inbox(const LcmBaseConfig& config, const Clock* clock)
      : clock_(clock),
        patience_(Seconds(config.patience_seconds)),
        sender_time_(config.synchronised, patience_, Duration::zero()) {}

  /// @throws ProtocolError for a pose that is none.
  void ReceivePose(const transport::Message& message) {
    const Time arrival = clock_->Now();
    const auto pose = transport::Decode<base_pose_t>(message);
    BaseState state{sender_time_.Of(StampOf(pose.utime), arrival), PoseOf(pose.X_WB),
                    PoseOf(pose.X_OB)};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) state.covariance_WB(i, j) = pose.covariance_WB[i][j];
    }
    const Eigen::Matrix3d transposed = state.covariance_WB.transpose();
    if (!transposed.isApprox(state.covariance_WB, 1e-6) ||
        state.covariance_WB.diagonal().minCoeff() < 0.0) {
      Throw<ProtocolError>(
          "covariance_WB is no covariance: it must be symmetric, and its diagonal "
          "not negative");
    }
    const std::scoped_lock lock(mutex_);
    if (state_ && state.time <= state_->time) return;  // late
    state_ = state;
    arrived_at_ = arrival;
    fault_.clear();
    came_.notify_all();
  }

  void ReceiveStatus(const transport::Message& message) {
    const Time arrival = clock_->Now();
    auto status = transport::Decode<base_status_t>(message);
    const std::scoped_lock lock(mutex_);
    status_ = std::move(status);
    status_at_ = arrival;
  }

  void Reject(const std::string& why) {
    const std::scoped_lock lock(mutex_);
    fault_ = why;
  }

  /// Waits up to `timeout` (of the machine) for a first pose.
  void WaitForPose(Duration timeout) {
    std::unique_lock lock(mutex_);
    came_.wait_for(lock, timeout, [&] { return state_.has_value(); });
  }

  /// The newest pose; empty when it is too old.
  std::optional<BaseState> state() const {
    const std::scoped_lock lock(mutex_);
    if (!state_ || clock_->Now() - arrived_at_ > patience_) return std::nullopt;
    return state_;
  }

  /// What was last said of the goal `id`, and when; empty when nothing was.
  std::optional<std::pair<base_status_t, Time>> StatusOf(std::int64_t id) const {
    const std::scoped_lock lock(mutex_);
    if (status_.id != id || id == 0) return std::nullopt;
    return std::pair(status_, status_at_);
  }

  /// What was wrong with the last message; empty: nothing, or there was none.
  std::string fault() const {
    const std::scoped_lock lock(mutex_);
    return fault_;
  }

 private:
  const Clock* clock_;
  const Duration patience_;
  SenderTime sender_time_;    // of the link's thread
  mutable std::mutex mutex_;  // of what follows
  std::condition_variable came_;
  std::optional<BaseState> state_;
  Time arrived_at_{};
  base_status_t status_{};
  Time status_at_{};
  std::string fault_;
};

void LcmBaseConfig::Validate() const {
  if (name.empty()) Throw<ConfigError>("'name' is empty: messages call the base by it");
  CheckRange(radius, 0.01, 5.0, "'radius'");
  CheckRange(height, 0.01, 5.0, "'height'");
  CheckRange(speed, 0.01, 5.0, "'speed'");
  CheckRange(turn_rate_deg, 1.0, 360.0, "'turn_rate_deg'");
  CheckRange(patience_seconds, 0.1, 60.0, "'patience_seconds'");
  CheckRange(renew_seconds, 0.01, 10.0, "'renew_seconds'");
  CheckRange(valid_seconds, 2.0 * renew_seconds, 60.0, "'valid_seconds'");
}

LcmBase::LcmBase(const LcmBaseConfig& config, std::shared_ptr<LcmLink> link, const Clock* clock)
    : config_(config), link_(std::move(link)), clock_(clock) {
  config_.Validate();
  info_ = {config_.name, config_.radius, config_.height, config_.speed,
           config_.turn_rate_deg * kDegree};
  inbox_ = std::make_shared<Inbox>(config_, clock_);
  const auto intake = [inbox = inbox_](const char* channel) {
    return transport::Intake{std::string(transport::TypeOn(channel)),
                             {},
                             transport::LcmBus::kQueue,
                             [inbox](const std::string& why) { inbox->Reject(why); }};
  };
  using transport::channel::kBasePose;
  using transport::channel::kBaseStatus;
  link_->Listen(kBasePose, intake(kBasePose),
                [inbox = inbox_](const auto& message) { inbox->ReceivePose(message); });
  link_->Listen(kBaseStatus, intake(kBaseStatus),
                [inbox = inbox_](const auto& message) { inbox->ReceiveStatus(message); });
  inbox_->WaitForPose(Seconds(config_.patience_seconds));
  if (!inbox_->state()) throw DeviceError(NoPose());
}

LcmBase::~LcmBase() { Stop(); }

BaseState LcmBase::State() {
  Status();  // keeps its goal alive
  const std::optional<BaseState> state = inbox_->state();
  if (!state) throw DeviceError(NoPose());
  return *state;
}

void LcmBase::Start(const BasePath& path) {
  CheckPath(path, info_.name);
  if (!inbox_->state()) throw DeviceError(NoPose());
  const Time now = clock_->Now();
  const std::scoped_lock lock(mutex_);
  // By the time, so that none is taken for one of an earlier process.
  goal_ = {std::max(goal_.id + 1, Microseconds(now)), path, now, now, false};
  status_ = {MotionPhase::kMoving, ""};
  Send(&goal_);
}

MotionStatus LcmBase::Status() {
  const std::scoped_lock lock(mutex_);
  if (status_.phase != MotionPhase::kMoving) return status_;
  status_ = Judge();
  if (status_.phase == MotionPhase::kMoving) {
    Renew(&goal_);
  } else if (status_.phase == MotionPhase::kFailed) {
    goal_.stopped = true;
    Send(&goal_);  // whatever it believes that it is to do
  }
  return status_;
}

void LcmBase::Stop() noexcept try {
  const std::scoped_lock lock(mutex_);
  if (status_.phase != MotionPhase::kMoving) return;
  goal_.stopped = true;
  Send(&goal_);
} catch (const std::exception& error) {
  spdlog::error("{}: cannot be told to stop, its goal lapses in {} s: {}", info_.name,
                config_.valid_seconds, error.what());
}

/// Sends the goal, or that it is given up. @pre mutex_ is held.
void LcmBase::Send(Goal* goal) {
  goal->sent_at = clock_->Now();
  const std::int64_t utime = Microseconds(goal->sent_at);
  if (goal->stopped) {
    base_cancel_t cancel{};
    cancel.utime = utime;
    cancel.id = goal->id;
    link_->Publish(transport::Pack(transport::channel::kBaseCancel, cancel));
    return;
  }
  base_goal_t message{};
  message.utime = utime;
  message.id = goal->id;
  message.valid_seconds = config_.valid_seconds;
  for (const Pose2& w : goal->path.waypoints_W) message.waypoints_W.push_back({w.x, w.y, w.yaw});
  message.num_waypoints = static_cast<std::int32_t>(message.waypoints_W.size());
  link_->Publish(transport::Pack(transport::channel::kBaseGoal, message));
}

void LcmBase::Renew(Goal* goal) {
  if (clock_->Now() - goal->sent_at >= Seconds(config_.renew_seconds)) Send(goal);
}

/// How far the goal is by what the base says. @pre mutex_ is held.
MotionStatus LcmBase::Judge() {
  const auto failed = [&](const std::string& why) {
    return MotionStatus{MotionPhase::kFailed, info_.name + ": " + why};
  };
  const auto said = inbox_->StatusOf(goal_.id);
  if (said) goal_.heard_at = std::max(goal_.heard_at, said->second);
  if (!said || said->first.phase == base_status_t::MOVING) {
    if (clock_->Now() - goal_.heard_at <= Seconds(config_.patience_seconds)) {
      return {MotionPhase::kMoving, ""};
    }
    return failed(
        fmt::format("no answer on {} to its {} for {} s: is the navigation running, and on {}?",
                    transport::channel::kBaseStatus, goal_.stopped ? "stop" : "goal",
                    config_.patience_seconds, link_->url()));
  }
  const base_status_t& status = said->first;
  if (status.phase == base_status_t::FAILED) return failed(status.reason);
  if (status.phase != base_status_t::REACHED) {
    if (goal_.stopped) return {MotionPhase::kStopped, ""};
    return failed("its navigation has given up the goal unasked: " + status.reason);
  }
  const std::optional<BaseState> state = inbox_->state();
  if (!state) return failed(NoPose());
  const Pose2& goal = goal_.path.waypoints_W.back();
  if (!IsReached(state->X_WB, goal)) {
    return failed(
        fmt::format("says that it has reached its goal {}, and is at {}: narrow the "
                    "tolerances of its navigation",
                    ToText(goal), ToText(state->X_WB)));
  }
  return {MotionPhase::kReached, ""};
}

std::string LcmBase::NoPose() const {
  const std::string fault = inbox_->fault();
  if (!fault.empty()) {
    return fmt::format("base '{}': no right pose on {} for {} s: {}", info_.name,
                       transport::channel::kBasePose, config_.patience_seconds, fault);
  }
  return fmt::format(
      "base '{}': no pose on {} of {} for {} s: is localisation running, and does it send there?",
      info_.name, transport::channel::kBasePose, link_->url(), config_.patience_seconds);
}

}  // namespace secondlook::hal
