#include "tests/lcm_drivers/base_follower.h"

#include <algorithm>
#include <utility>

#include "lib/hal/drivers/sender_time.h"
#include "lib/transport/channels.h"

#include "second_look/base_cancel_t.hpp"
#include "second_look/base_pose_t.hpp"
#include "second_look/base_status_t.hpp"

namespace secondlook::hal {
namespace {

using second_look::base_goal_t;
using second_look::base_status_t;

constexpr Duration kShort = Seconds(0.5);

void Copy(const Pose2& X, double (&values)[3]) {
  values[0] = X.x;
  values[1] = X.y;
  values[2] = X.yaw;
}

BasePath PathOf(const base_goal_t& goal) {
  BasePath path;
  for (const auto& w : goal.waypoints_W) path.waypoints_W.push_back({w[0], w[1], w[2]});
  return path;
}

}  // namespace

BaseFollower::BaseFollower(LcmLink* link, Base* base, const Clock* clock, Duration ahead)
    : link_(link), base_(base), clock_(clock), ahead_(ahead) {
  using transport::channel::kBaseCancel;
  using transport::channel::kBaseGoal;
  link_->Listen(kBaseGoal, {"second_look.base_goal_t", {}}, [this](const auto& message) {
    const std::scoped_lock lock(mutex_);
    heard_goal_ = transport::Decode<base_goal_t>(message);
    ++goals_heard_;
  });
  link_->Listen(kBaseCancel, {"second_look.base_cancel_t", {}}, [this](const auto& message) {
    const std::scoped_lock lock(mutex_);
    heard_cancel_ = transport::Decode<second_look::base_cancel_t>(message).id;
  });
}

int BaseFollower::goals_heard() const {
  const std::scoped_lock lock(mutex_);
  return goals_heard_;
}

void BaseFollower::Step() {
  if (fault_ != FollowerFault::kSilent) Obey();
  Tell();
}

void BaseFollower::Obey() {
  std::optional<base_goal_t> goal;
  std::optional<std::int64_t> cancel;
  {
    const std::scoped_lock lock(mutex_);
    goal = std::exchange(heard_goal_, std::nullopt);
    cancel = std::exchange(heard_cancel_, std::nullopt);
  }
  if (goal) Hear(*goal);
  const Time now = clock_->Now();
  const bool lapsed = goal_.id != 0 && now > goal_.heard_at + goal_.valid;
  const bool spoilt = fault_ == FollowerFault::kStopsShort || fault_ == FollowerFault::kGivesUp;
  const bool cut = spoilt && goal_.id != 0 && now > goal_.begun_at + kShort;
  if (cut && base_->Status().phase == MotionPhase::kMoving) cut_short_ = true;
  if ((cancel && *cancel == goal_.id) || lapsed || cut) base_->Stop();
}

void BaseFollower::Hear(const base_goal_t& message) {
  const Time now = clock_->Now();
  if (message.id > goal_.id) {
    goal_ = {message.id, now, now, Seconds(message.valid_seconds)};
    cut_short_ = false;
    base_->Start(PathOf(message));
  }
  if (message.id == goal_.id) goal_.heard_at = now;
}

void BaseFollower::Tell() {
  const BaseState state = base_->State();
  if (fault_ != FollowerFault::kNoPose) {
    second_look::base_pose_t pose{};
    pose.utime = Microseconds(state.time + ahead_);
    Copy(state.X_WB, pose.X_WB);
    Copy(state.X_OB, pose.X_OB);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) pose.covariance_WB[i][j] = state.covariance_WB(i, j);
    }
    link_->Publish(transport::Pack(transport::channel::kBasePose, pose));
  }
  if (fault_ == FollowerFault::kSilent) return;
  const MotionStatus motion = base_->Status();
  base_status_t status{};
  status.utime = Microseconds(clock_->Now() + ahead_);
  status.id = goal_.id;
  status.phase = static_cast<std::int8_t>(motion.phase);
  status.reason = motion.reason;
  if (cut_short_ && motion.phase == MotionPhase::kStopped) {
    const bool lies = fault_ == FollowerFault::kStopsShort;
    status.phase = lies ? base_status_t::REACHED : base_status_t::FAILED;
    if (!lies) status.reason = "no way round";
  }
  link_->Publish(transport::Pack(transport::channel::kBaseStatus, status));
}

}  // namespace secondlook::hal
