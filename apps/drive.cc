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

/// Waits until `status` no longer says moving.
DriveOutcome WaitFor(const std::string& what, const std::function<MotionStatus()>& status,
                     Duration limit, const StopRequest& stop, const MotionListener& moving,
                     hal::Robot* robot, Capturer* capturer) {
  DriveOutcome outcome;
  int polls = 0;
  const Time deadline = robot->clock->Now() + limit;
  Pose2 last = robot->base->State().X_WB;
  while (true) {
    const MotionStatus now = status();
    const Pose2 here = robot->base->State().X_WB;
    outcome.metres += std::hypot(here.x - last.x, here.y - last.y);
    last = here;
    if (now.phase == MotionPhase::kReached) return outcome;
    if (now.phase == MotionPhase::kFailed || now.phase == MotionPhase::kStopped) {
      outcome.kind = Kind::kFailed;
      outcome.reason = fmt::format("{}: {}", what, now.reason.empty() ? "stopped" : now.reason);
      return outcome;
    }
    if (stop()) {
      robot->Stop();
      outcome.kind = Kind::kStopped;
      outcome.reason = fmt::format("{}: stopped on request", what);
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
    robot->base->Start({look.path_W});
    outcome = WaitFor(
        robot->base->info().name, [&] { return robot->base->Status(); }, limit, stop, moving, robot,
        capturer);
    outcome.base_failed = outcome.kind == Kind::kFailed;
    if (outcome.kind != Kind::kReached) return outcome;
  }
  robot->head->Start(look.head);
  DriveOutcome head = WaitFor(
      robot->head->info().name, [&] { return robot->head->Status(); }, limit, stop,
      [&](double metres) { moving(outcome.metres + metres); }, robot, capturer);
  head.metres += outcome.metres;
  return head;
} catch (...) {
  robot->Stop();
  throw;
}

}  // namespace secondlook::apps
