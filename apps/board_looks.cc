#include "apps/board_looks.h"

#include <utility>

#include "apps/stop_signal.h"
#include "lib/common/error.h"

namespace secondlook::apps {
namespace {

constexpr Duration kPoll = Seconds(0.05);
constexpr Duration kSettle = Seconds(0.3);   // until nothing swings any longer
constexpr Duration kPatience = Seconds(20);  // with a frame, or a motion of the head …
constexpr double kSlower = 3.0;  // … and so many times as long as an arm's motion takes

}  // namespace

std::optional<kinematics::BoardView> BoardLooks::WithHead(const hal::PanTiltAngles& target) {
  robot_->head->Start(target);
  Complete("pan-tilt '" + robot_->head->info().name + "'", kPatience,
           [&] { return robot_->head->Status(); });
  const Time still = Settle();
  auto seen = Sight(robot_->head_camera.get(), still);
  if (!seen) return std::nullopt;
  const hal::PanTiltAngles at = robot_->head->State().angles;
  return kinematics::BoardView{{at.pan, at.tilt}, *std::move(seen)};
}

std::optional<kinematics::HandView> BoardLooks::WithHand() {
  const Time still = Settle();
  auto seen = Sight(robot_->hand_camera.get(), still);
  if (!seen) return std::nullopt;
  return kinematics::HandView{robot_->arm->State().q, *std::move(seen)};
}

void BoardLooks::MoveArm(const hal::JointTrajectory& trajectory) {
  if (trajectory.knots.empty()) return;
  robot_->arm->Start(trajectory);
  Complete("arm '" + robot_->arm->info().name + "'",
           kPatience + Seconds(kSlower * trajectory.seconds()),
           [&] { return robot_->arm->Status(); });
}

/// Waits until the motion of `device` has ended.
void BoardLooks::Complete(const std::string& device, Duration patience,
                          const std::function<hal::MotionStatus()>& ask) {
  const Time deadline = robot_->clock->Now() + patience;
  hal::MotionStatus status = ask();
  for (; status.phase == hal::MotionPhase::kMoving; status = ask()) {
    if (StopSignal() != 0) {
      robot_->Stop();
      throw Stopped{};
    }
    if (robot_->clock->Now() > deadline) {
      robot_->Stop();
      Throw<DeviceError>("{}: still moving after {} s", device, ToSeconds(patience));
    }
    robot_->clock->SleepUntil(robot_->clock->Now() + kPoll);
  }
  if (status.phase != hal::MotionPhase::kReached) {
    Throw<DeviceError>("{}: did not get there: {}", device, status.reason);
  }
}

/// Waits until nothing swings any longer. Returns when that is.
Time BoardLooks::Settle() {
  const Time still = robot_->clock->Now() + kSettle;
  robot_->clock->SleepUntil(still);
  return still;
}

/// The board in the first frame of `camera` that was taken after `still`.
std::optional<kinematics::SightedBoard> BoardLooks::Sight(hal::Camera* camera, Time still) {
  const Time deadline = robot_->clock->Now() + kPatience;
  while (robot_->clock->Now() < deadline) {
    if (StopSignal() != 0) throw Stopped{};
    const std::optional<hal::RgbdFrame> frame = camera->Grab(Seconds(1.0));
    if (!frame || frame->time < still) continue;
    auto seen = perception::FindBoard(frame->color, camera->info().model, board_);
    if (!seen) return std::nullopt;
    return kinematics::SightedBoard{std::move(seen->corners), std::move(seen->points_P),
                                    seen->X_CP};
  }
  Throw<DeviceError>("camera '{}': no new frame in {} s", camera->info().name,
                     ToSeconds(kPatience));
}

}  // namespace secondlook::apps
