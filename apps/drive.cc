#include "apps/drive.h"

#include <cmath>

#include "lib/common/error.h"

namespace secondlook::apps {
namespace {

using hal::MotionPhase;
using hal::MotionStatus;
using Kind = DriveOutcome::Kind;

constexpr Duration kPoll = Seconds(0.05);
/// Every so many polls it is told how far the motion is.
constexpr int kPollsPerTelling = 5;

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

}  // namespace

DriveOutcome MoveTo(const world::Look& look, const StopRequest& stop, const MotionListener& moving,
                    hal::Robot* robot, Capturer* capturer) try {
  const Duration limit = Seconds(3.0 * look.seconds + 15.0);
  DriveOutcome outcome;
  if (!look.path_W.empty()) {
    const Motion drive{robot->base->info().name, [&] { robot->base->Start({look.path_W}); },
                       [&] { return robot->base->Status(); }};
    outcome = Complete(drive, limit, stop, moving, robot, capturer);
    outcome.base_failed = outcome.kind == Kind::kFailed;
    if (outcome.kind != Kind::kReached) return outcome;
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
