#include "apps/capture.h"

#include <algorithm>

#include <opencv2/core.hpp>

#include "lib/common/error.h"
#include "lib/perception/own_body.h"

namespace secondlook::apps {
namespace {

constexpr Duration kKeep = Seconds(10);
/// Around the robot's body: the errors of calibration, joints and depth, and of stamps.
constexpr double kBodyMargin = 0.04;  // [m]
/// How long after a frame's time the states may come in.
constexpr Duration kSettle = Seconds(0.05);
/// What is measured may be stamped so much later than it is, by the error of its stamp.
constexpr Duration kMaxAhead = Seconds(0.5);
/// More frames from the past than this in a row, and the camera's stamps are wrong.
constexpr int kMaxStale = 10;

/// @throws DeviceError naming `device` when what it says is of the future: stamps that jump ahead
/// would leave it out of the histories of what comes after them.
void RequireNotAhead(const std::string& device, Time measured, Time now) {
  if (measured <= now + kMaxAhead) return;
  Throw<DeviceError>(
      "{}: its newest state is stamped {:.3f} s ahead of the robot's clock; check its clock and "
      "its "
      "time stamps",
      device, ToSeconds(measured - now));
}

}  // namespace

double ShareWithDepth(const cv::Mat& depth) {
  if (depth.empty()) return 0.0;
  // A comparison with NaN is false.
  return cv::countNonZero(depth > 0.0) / static_cast<double>(depth.total());
}

Capturer::Capturer(hal::Robot* robot, const kinematics::HeadCalibration& calibration)
    : robot_(robot), calibration_(calibration), X_WB_("X_WB", kKeep), X_BC_("X_BC", kKeep) {}

void Capturer::Poll() {
  const hal::BaseState base = robot_->base->State();
  const hal::PanTiltState head = robot_->head->State();
  const Time now = robot_->clock->Now();
  RequireNotAhead("base '" + robot_->base->info().name + "'", base.time, now);
  RequireNotAhead("pan-tilt '" + robot_->head->info().name + "'", head.time, now);
  X_WB_.Add(base.time, ToPose(base.X_WB));
  X_BC_.Add(head.time, CameraInBase(calibration_, {head.angles.pan, head.angles.tilt}));
  if (!hand_ || arm_lost_) return;
  hal::ArmState arm = robot_->arm->State();
  RequireNotAhead("arm '" + robot_->arm->info().name + "'", arm.time, now);
  if (!arm_states_.empty() && arm.time <= arm_states_.back().time) return;
  arm_states_.push_back(std::move(arm));
  while (arm_states_.front().time < arm_states_.back().time - kKeep) arm_states_.pop_front();
}

std::optional<Capture> Capturer::Take(Duration timeout, world::LookWay way) {
  hal::Camera& camera = way == world::LookWay::kArm ? *robot_->hand_camera : *robot_->head_camera;
  // Standing still from before the frame to after it, so that both histories cover its time.
  Poll();
  robot_->clock->SleepUntil(robot_->clock->Now() + kSettle);
  Poll();
  const Time begin = robot_->clock->Now();
  // Frames from before the last motion ended may still have been waiting, but not for ever.
  std::optional<hal::RgbdFrame> frame = camera.Grab(timeout);
  for (int i = 0; i < kMaxStale && frame && frame->time < begin - kSettle; ++i) {
    frame = camera.Grab(timeout);
  }
  if (frame && frame->time < begin - kSettle) {
    Throw<DeviceError>(
        "camera '{}': its newest frame is {:.3f} s old; check its clock and its time stamps",
        camera.info().name, ToSeconds(robot_->clock->Now() - frame->time));
  }
  if (!frame) return std::nullopt;
  const Time now = robot_->clock->Now();
  if (frame->time > now + kMaxAhead) {
    Throw<DeviceError>(
        "camera '{}': its newest frame is stamped {:.3f} s ahead of the robot's clock; check its "
        "clock and its time stamps",
        camera.info().name, ToSeconds(frame->time - now));
  }
  robot_->clock->SleepUntil(frame->time + kSettle);
  Poll();
  return At(*frame, camera.info(), way);
}

Eigen::VectorXd Capturer::ArmNow() const {
  return arm_lost_ ? arm_states_.back().q : robot_->arm->State().q;
}

Eigen::VectorXd Capturer::ArmAt(Time time) const {
  if (arm_lost_) return arm_states_.back().q;
  const auto after =
      std::lower_bound(arm_states_.begin(), arm_states_.end(), time,
                       [](const hal::ArmState& state, Time t) { return state.time < t; });
  if (after == arm_states_.end() || (after == arm_states_.begin() && after->time > time)) {
    Throw<InvalidArgument>("the joints of arm '{}' are not known at {:.3f} s",
                           robot_->arm->info().name, ToSeconds(time));
  }
  if (after->time == time) return after->q;
  const hal::ArmState& before = *std::prev(after);
  const double share = ToSeconds(time - before.time) / ToSeconds(after->time - before.time);
  return (1.0 - share) * before.q + share * after->q;
}

/// The capture of `frame`: a frame from a time when the robot's pose is not known is the fault of
/// somebody's clock.
Capture Capturer::At(const hal::RgbdFrame& frame, const hal::CameraInfo& camera,
                     world::LookWay way) const try {
  const Pose X_WB = X_WB_.At(frame.time);
  const Pose X_BC =
      way == world::LookWay::kArm ? CameraInBase(*hand_, ArmAt(frame.time)) : X_BC_.At(frame.time);
  const Pose X_WC = X_WB * X_BC;
  Capture capture{camera.name, frame, camera.model, X_WC, X_WB.translation() - X_WC.translation()};
  if (hand_) {
    const Pose X_CB = X_BC.inverse();
    std::vector<geometry::PlacedShape> body_C = hand_->arm.Body(ArmAt(frame.time));
    for (geometry::PlacedShape& part : body_C) part.X_AS = X_CB * part.X_AS;
    capture.frame.depth =
        perception::WithoutOwnBody(frame.depth, capture.camera, body_C, kBodyMargin);
  }
  return capture;
} catch (const InvalidArgument& error) {
  Throw<DeviceError>(
      "camera '{}': no pose for its frame {}: {}; check that camera, base, head and arm stamp with "
      "one clock",
      camera.name, frame.sequence, error.what());
}

}  // namespace secondlook::apps
