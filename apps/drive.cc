#include "apps/drive.h"

#include <cmath>
#include <numbers>

#include "lib/common/error.h"

namespace secondlook::apps {
namespace {

using hal::MotionPhase;
using hal::MotionStatus;
using Kind = DriveOutcome::Kind;

constexpr Duration kPoll = Seconds(0.05);
/// Every so many polls it is told how far the motion is.
constexpr int kPollsPerTelling = 5;

/// What hal::Base calls reached.
constexpr double kReached_m = 0.1;
constexpr double kReached_rad = 5.0 * std::numbers::pi / 180.0;

/// A motion of one device.
struct Motion {
  std::string device;
  std::function<void()> start;
  std::function<MotionStatus()> status;
};

/// Starts it and waits until its status no longer says moving. When asked to stop, that comes
/// first: others may have stopped the device already.
DriveOutcome Complete(const Motion& motion, Duration limit, const StopRequest& stop,
                      const MotionListener& moving, hal::Robot* robot, Capturer* capturer) {
  const auto& what = motion.device;
  DriveOutcome outcome;
  const auto stopped = [&] {
    robot->Stop();
    outcome.kind = Kind::kStopped;
    outcome.reason = fmt::format("{}: stopped on request", what);
    return outcome;
  };
  if (stop()) return stopped();
  motion.start();
  int polls = 0;
  const Time deadline = robot->clock->Now() + limit;
  Pose2 last = robot->base->State().X_WB;
  while (true) {
    const MotionStatus now = motion.status();
    const Pose2 here = robot->base->State().X_WB;
    outcome.metres += std::hypot(here.x - last.x, here.y - last.y);
    last = here;
    if (stop()) return stopped();
    if (now.phase == MotionPhase::kReached) return outcome;
    if (now.phase == MotionPhase::kFailed || now.phase == MotionPhase::kStopped) {
      outcome.kind = Kind::kFailed;
      outcome.reason = fmt::format("{}: {}", what, now.reason.empty() ? "stopped" : now.reason);
      return outcome;
    }
    if (robot->clock->Now() >= deadline) {
      robot->Stop();
      outcome.kind = Kind::kFailed;
      outcome.reason = fmt::format("{}: still moving after {:.1f} s", what, ToSeconds(limit));
      return outcome;
    }
    robot->clock->SleepUntil(robot->clock->Now() + kPoll);
    capturer->Poll();
    if (++polls % kPollsPerTelling == 0) moving(outcome.metres);
  }
}

/// Why the base, which says that it has reached `goal_W`, is not there; empty when it is.
std::string Missed(const Pose2& goal_W, hal::Base& base) {
  const Pose2 X_WB = base.State().X_WB;
  const double off = std::hypot(X_WB.x - goal_W.x, X_WB.y - goal_W.y);
  const double turned = std::abs(WrapAngle(X_WB.yaw - goal_W.yaw));
  if (off <= kReached_m && turned <= kReached_rad) return "";
  return fmt::format(
      "{}: says it has reached its goal, but localisation sees it {:.2f} m and {:.1f} deg away",
      base.info().name, off, turned * 180.0 / std::numbers::pi);
}

}  // namespace

DriveOutcome MoveTo(const world::Look& look, const StopRequest& stop, const MotionListener& moving,
                    hal::Robot* robot, Capturer* capturer) try {
  const Duration limit = Seconds(3.0 * look.seconds + 15.0);
  DriveOutcome outcome;
  if (!look.arm_motion.knots.empty()) {
    const Motion reach{robot->arm->info().name, [&] { robot->arm->Start(look.arm_motion); },
                       [&] { return robot->arm->Status(); }};
    outcome = Complete(reach, limit, stop, moving, robot, capturer);
    if (outcome.kind != Kind::kReached || look.way == world::LookWay::kArm) return outcome;
  }
  if (!look.path_W.empty()) {
    const Motion drive{robot->base->info().name, [&] { robot->base->Start({look.path_W}); },
                       [&] { return robot->base->Status(); }};
    outcome = Complete(drive, limit, stop, moving, robot, capturer);
    outcome.base_failed = outcome.kind == Kind::kFailed;
    if (outcome.kind != Kind::kReached) return outcome;
    outcome.reason = Missed(look.path_W.back(), *robot->base);
    if (!outcome.reason.empty()) {
      outcome.kind = Kind::kFailed;
      return outcome;
    }
  }
  const Motion turn{robot->head->info().name, [&] { robot->head->Start(look.head); },
                    [&] { return robot->head->Status(); }};
  DriveOutcome head = Complete(
      turn, limit, stop, [&](double metres) { moving(outcome.metres + metres); }, robot, capturer);
  head.metres += outcome.metres;
  return head;
} catch (...) {
  robot->Stop();
  throw;
}

}  // namespace secondlook::apps
