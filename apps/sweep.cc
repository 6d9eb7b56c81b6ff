#include "apps/sweep.h"

#include <utility>

#include "lib/common/pose_history.h"

namespace secondlook::apps {
namespace {

using hal::MotionPhase;
using Kind = DriveOutcome::Kind;

constexpr Duration kPoll = Seconds(0.01);
constexpr Duration kKeep = Seconds(60.0);     // poses; a sweep is far shorter
constexpr Duration kUnderWay = Seconds(0.1);  // lines, after the last was measured

/// Follows trajectories with an arm and remembers where its laser was.
class LaserCourse {
 public:
  LaserCourse(const LaserMount& mount, const Pose& X_WB, const StopRequest& stop, hal::Robot* robot)
      : mount_(mount), X_WB_(X_WB), stop_(stop), robot_(*robot), X_WL_("X_WL", kKeep) {}

  const PoseHistory& X_WL() const { return X_WL_; }
  Time last() const { return last_; }

  /// Notes where the laser is now.
  void Note() {
    const hal::ArmState state = robot_.arm->State();
    X_WL_.Add(state.time, X_WB_ * mount_.arm.TipPose(state.q) * mount_.X_EL);
    last_ = state.time;
  }

  /// Waits a moment and notes where the laser is then.
  void Pause() {
    robot_.clock->SleepUntil(robot_.clock->Now() + kPoll);
    Note();
  }

  /// Follows `trajectory` to its end, calling `meanwhile` again and again.
  template <class Meanwhile>
  DriveOutcome Follow(const hal::JointTrajectory& trajectory, const Meanwhile& meanwhile) {
    const std::string& arm = robot_.arm->info().name;
    if (stop_()) return {Kind::kStopped, arm + ": stopped on request"};
    const Time deadline = robot_.clock->Now() + Seconds(3.0 * trajectory.seconds() + 15.0);
    robot_.arm->Start(trajectory);
    while (true) {
      Pause();
      meanwhile();
      const hal::MotionStatus status = robot_.arm->Status();
      if (status.phase == MotionPhase::kReached) return {};
      if (status.phase == MotionPhase::kStopped) {
        return {Kind::kStopped, arm + ": stopped on its way"};
      }
      if (status.phase != MotionPhase::kMoving) {
        return {Kind::kFailed, fmt::format("{}: {}", arm, status.reason)};
      }
      if (stop_()) {
        robot_.Stop();
        return {Kind::kStopped, arm + ": stopped on request"};
      }
      if (robot_.clock->Now() >= deadline) {
        robot_.Stop();
        return {Kind::kFailed, arm + ": still moving long after it should have arrived"};
      }
    }
  }

 private:
  const LaserMount& mount_;
  const Pose X_WB_;
  const StopRequest& stop_;
  hal::Robot& robot_;
  PoseHistory X_WL_;
  Time last_{};
};

}  // namespace

Swept RunSweep(const planning::PlannedSweep& plan, const LaserMount& mount, const Pose& X_WB,
               const StopRequest& stop, hal::Robot* robot,
               const perception::LaserPrecision& precision) try {
  hal::LaserStriper& striper = *robot->striper;
  LaserCourse course(mount, X_WB, stop, robot);
  Swept swept;
  swept.motion = course.Follow(plan.approach, [] {});
  if (swept.motion.kind != Kind::kReached) return swept;

  striper.Take();  // what an earlier scan left
  const std::uint64_t lost_before = striper.lost();
  std::vector<hal::ScanLine> lines;
  const auto take = [&] {
    for (hal::ScanLine& line : striper.Take()) lines.push_back(std::move(line));
  };
  course.Note();
  const Time begin = course.last();
  striper.On();
  swept.motion = course.Follow(plan.sweep, take);
  striper.Off();
  const Time end = robot->clock->Now() + kUnderWay;
  while (robot->clock->Now() < end) {
    course.Pause();
    take();
  }
  swept.lost = striper.lost() - lost_before;
  const std::size_t came = lines.size();
  std::erase_if(lines, [&](const hal::ScanLine& line) {
    return line.time < begin || line.time > course.last();
  });
  swept.without_place = came - lines.size();
  swept.lines = static_cast<int>(lines.size());
  swept.scan = perception::StripedScan(lines, striper.info(), course.X_WL(), precision);
  return swept;
} catch (...) {
  robot->Stop();
  throw;
}

}  // namespace secondlook::apps
