#include "lib/hal/drivers/flir_ptu.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "lib/common/check_range.h"
#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kArcSecond = kDegree / 3600.0;
constexpr double kReached = 0.25 * kDegree;       // half of what PanTilt::Status() allows
constexpr double kStill = 0.02 * kDegree;         // less than a count of the unit
constexpr Duration kTellsMotion = Seconds(0.05);  // two measurements so far apart do
constexpr Duration kStalled = Seconds(1.0);

double Distance(const PanTiltAngles& a, const PanTiltAngles& b) {
  return std::max(std::abs(a.pan - b.pan), std::abs(a.tilt - b.tilt));
}

std::string Degrees(const PanTiltAngles& angles) {
  // Rounded before it is written, so that no zero has a sign.
  const auto hundredths = [](double angle) {
    return std::round(100.0 * angle / kDegree) / 100.0 + 0.0;
  };
  return fmt::format("pan {:.2f}, tilt {:.2f} deg", hundredths(angles.pan),
                     hundredths(angles.tilt));
}

}  // namespace

void FlirPtuConfig::Validate() const {
  if (device.empty()) Throw<ConfigError>("'device' is empty: give the port, e.g. /dev/ttyUSB0");
  CheckRange(speed_deg, 0.1, 300.0, "'speed_deg'");
  CheckRange(poll_seconds, 0.0, 1.0, "'poll_seconds'");
}

FlirPtu::FlirPtu(const FlirPtuConfig& config, const Clock* clock) : config_(config), clock_(clock) {
  config_.Validate();
  Connect();
  if (config_.home) {
    link_->Reset();
    Connect();  // it begins anew
  }
  Measure();
  thread_ = std::thread([this] { Run(); });
}

FlirPtu::~FlirPtu() {
  Stop();
  quit_ = true;
  wake_.notify_all();
  thread_.join();
}

PanTiltState FlirPtu::State() {
  const std::scoped_lock lock(mutex_);
  if (!lost_.empty()) throw DeviceError(lost_);
  return state_;
}

void FlirPtu::Start(const PanTiltAngles& target) {
  if (!info_.Reaches(target)) {
    Throw<InvalidArgument>("{}: {} is outside its limits, {} to {}", info_.name, Degrees(target),
                           Degrees(info_.lower), Degrees(info_.upper));
  }
  const std::scoped_lock lock(mutex_);
  if (!lost_.empty()) throw DeviceError(lost_);
  motion_ = Motion{target, state_, state_.time};
  status_ = {MotionPhase::kMoving, ""};
  halt_ = false;
  wake_.notify_all();
}

MotionStatus FlirPtu::Status() {
  const std::scoped_lock lock(mutex_);
  return status_;
}

void FlirPtu::Stop() noexcept {
  const std::scoped_lock lock(mutex_);
  halt_ = true;
  wake_.notify_all();
}

void FlirPtu::Connect() {
  link_ = std::make_unique<FlirPtuLink>(config_.device, config_.baud);
  ReadInfo();
}

FlirPtu::Scale FlirPtu::ReadScale() {
  return {(config_.pan_positive_left ? 1.0 : -1.0) * link_->Ask("pr") * kArcSecond,
          (config_.tilt_positive_up ? -1.0 : 1.0) * link_->Ask("tr") * kArcSecond};
}

/// Reads resolution and limits, and sets the speed.
void FlirPtu::ReadInfo() {
  scale_ = ReadScale();
  const auto [pan_lower, pan_upper] =
      std::minmax({link_->Ask("pn") * scale_.pan, link_->Ask("px") * scale_.pan});
  const auto [tilt_lower, tilt_upper] =
      std::minmax({link_->Ask("tn") * scale_.tilt, link_->Ask("tx") * scale_.tilt});
  const double speed =
      std::min({config_.speed_deg * kDegree, link_->Ask("pu") * std::abs(scale_.pan),
                link_->Ask("tu") * std::abs(scale_.tilt)});
  if (!(speed > 0.0) || !(pan_upper > pan_lower) || !(tilt_upper > tilt_lower)) {
    Throw<DeviceError>(
        "{}: the pan-tilt unit's own figures contradict each other: pan {:.1f} to {:.1f}, tilt "
        "{:.1f} to {:.1f} deg, {:.1f} deg/s",
        config_.device, pan_lower / kDegree, pan_upper / kDegree, tilt_lower / kDegree,
        tilt_upper / kDegree, speed / kDegree);
  }
  link_->Do(fmt::format("ps{:.0f}", std::floor(speed / std::abs(scale_.pan))));
  link_->Do(fmt::format("ts{:.0f}", std::floor(speed / std::abs(scale_.tilt))));
  info_ = {"pan-tilt unit at " + config_.device,
           {pan_lower, tilt_lower},
           {pan_upper, tilt_upper},
           speed};
}

void FlirPtu::Run() {
  while (!quit_) {
    try {
      if (link_ == nullptr) {
        Connect();
        spdlog::warn("{}: is back", info_.name);
      }
      HaltWhenAsked();
      Turn();
      Measure();
    } catch (const Error& error) {
      Lose(error.what());
    }
    std::unique_lock lock(mutex_);
    const double wait = lost_.empty() ? config_.poll_seconds : 1.0;
    wake_.wait_for(lock, Seconds(wait), [&] {
      return quit_ || (lost_.empty() && (halt_ || (motion_ && !motion_->started)));
    });
  }
  try {
    if (link_ != nullptr) link_->Do("h");
  } catch (const Error& error) {
    spdlog::warn("{}; it could not be halted at the end", error.what());
  }
}

void FlirPtu::HaltWhenAsked() {
  {
    const std::scoped_lock lock(mutex_);
    if (!halt_) return;
    halt_ = false;
    if (motion_) motion_->started = motion_->halted = true;
  }
  link_->Do("h");
}

/// Tells the unit of a motion that it does not know of.
void FlirPtu::Turn() {
  PanTiltAngles target;
  {
    const std::scoped_lock lock(mutex_);
    if (!motion_ || motion_->started) return;
    motion_->started = true;
    target = motion_->target;
  }
  try {
    link_->Do(fmt::format("pp{:.0f}", target.pan / scale_.pan));
    link_->Do(fmt::format("tp{:.0f}", target.tilt / scale_.tilt));
  } catch (const ProtocolError& refusal) {
    const std::scoped_lock lock(mutex_);
    End({MotionPhase::kFailed, refusal.what()});
  }
}

void FlirPtu::Measure() {
  const Time before = clock_->Now();
  const PanTiltAngles angles{link_->Ask("pp") * scale_.pan, link_->Ask("tp") * scale_.tilt};
  const Time time = before + (clock_->Now() - before) / 2;
  const std::scoped_lock lock(mutex_);
  Judge({time, angles});
  state_ = {time, angles};
  lost_.clear();
}

/// Says how far the motion is, now that the head is in `state`. @pre mutex_ is held.
void FlirPtu::Judge(const PanTiltState& state) {
  if (!motion_ || !motion_->started || state.time - motion_->last.time < kTellsMotion) return;
  const bool still = Distance(state.angles, motion_->last.angles) < kStill;
  motion_->last = state;
  if (!still) {
    motion_->progress_at = state.time;
  } else if (motion_->halted) {
    End({MotionPhase::kStopped, ""});
  } else if (Distance(state.angles, motion_->target) < kReached) {
    End({MotionPhase::kReached, ""});
  } else if (state.time - motion_->progress_at > kStalled) {
    End({MotionPhase::kFailed,
         fmt::format("{}: stands still at {} and not at {}: is something in its way?", info_.name,
                     Degrees(state.angles), Degrees(motion_->target))});
  }
}

/// @pre mutex_ is held.
void FlirPtu::End(const MotionStatus& status) {
  if (motion_) status_ = status;
  motion_.reset();
}

void FlirPtu::Lose(const std::string& why) {
  link_.reset();
  const std::scoped_lock lock(mutex_);
  if (lost_.empty() && !quit_) spdlog::error("{}", why);
  lost_ = why;
  End({MotionPhase::kFailed, why});
}

}  // namespace secondlook::hal
