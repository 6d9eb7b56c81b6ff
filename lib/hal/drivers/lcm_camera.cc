#include "lib/hal/drivers/lcm_camera.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/hal/drivers/frame_mailbox.h"
#include "lib/hal/drivers/rgbd_message.h"
#include "lib/hal/drivers/sender_time.h"

namespace secondlook::hal {
namespace {

constexpr int kQueue = 4;

CameraInfo InfoOf(const LcmCameraConfig& config) {
  CameraModel model{config.width,         config.height,        config.intrinsics[0],
                    config.intrinsics[1], config.intrinsics[2], config.intrinsics[3]};
  model.Validate(("camera '" + config.name + "'").c_str());
  if (!config.depth) return {config.name, model, false, 0.0, 0.0};
  return {config.name, model, true, config.min_depth, config.max_depth};
}

/// As long as the longest message there can be: both images as they are, or as compression that
/// gains nothing leaves them.
transport::Intake IntakeOf(const CameraModel& model) {
  const std::int64_t pixels = std::int64_t{model.width} * model.height;
  transport::Intake intake{"bot_core.images_t", {}, kQueue};
  intake.limits.data = 4 * pixels + 4096;
  intake.limits.bytes = static_cast<std::size_t>(8 * pixels + 65'536);
  intake.limits.values = 16;
  return intake;
}

}  // namespace

/// Takes what comes in and keeps the newest good frame. Threading: any.
class LcmCamera::Inbox {
 public:
  Inbox(const LcmCameraConfig& config, const CameraInfo& info, const Clock* clock)
      : info_(info),
        clock_(clock),
        patience_(Seconds(config.patience_seconds)),
        max_apart_(Seconds(config.max_apart_seconds)),
        sender_time_(config.synchronised, patience_, Seconds(config.latency_seconds)),
        good_at_(clock->Now()) {}

  /// @throws ProtocolError for a message that is no good frame.
  void Receive(const transport::Message& message) {
    const Time arrival = clock_->Now();
    ++sequence_;
    ReceivedImages images =
        ReadImages(transport::Decode<bot_core::images_t>(message), info_, max_apart_);
    const Time time = sender_time_.Of(images.stamp, arrival);
    if (time <= last_) {
      Throw<ProtocolError>(
          "its stamps do not advance: is the camera stuck, or sent by two senders?");
    }
    last_ = time;
    mailbox_.Put({time, sequence_, std::move(images.color), std::move(images.depth)});
    const std::scoped_lock lock(mutex_);
    good_at_ = arrival;
    fault_.clear();
  }

  void Reject(const std::string& why) {
    const std::scoped_lock lock(mutex_);
    fault_ = why;
  }

  std::optional<RgbdFrame> Take(Duration timeout) { return mailbox_.Take(timeout); }

  /// How much longer it may last until the camera is lost.
  Duration PatienceLeft() const {
    const std::scoped_lock lock(mutex_);
    return patience_ - (clock_->Now() - good_at_);
  }

  /// What was wrong with the last message; empty: nothing, or there was none.
  std::string fault() const {
    const std::scoped_lock lock(mutex_);
    return fault_;
  }

 private:
  const CameraInfo info_;
  const Clock* clock_;
  const Duration patience_;
  const Duration max_apart_;
  SenderTime sender_time_;  // these three of the link's thread
  std::uint64_t sequence_{};
  Time last_{};
  FrameMailbox mailbox_;
  mutable std::mutex mutex_;  // of what follows
  Time good_at_;
  std::string fault_;
};

void LcmCameraConfig::Validate() const {
  if (name.empty()) Throw<ConfigError>("'name' is empty: messages call the camera by it");
  if (channel.empty()) Throw<ConfigError>("'channel' is empty: give the one its images come on");
  CheckRange(width, 1, 4096, "'width'");
  CheckRange(height, 1, 4096, "'height'");
  CheckRange(min_depth, 0.0, 60.0, "'min_depth'");
  CheckRange(max_depth, min_depth, 65.0, "'max_depth'");
  CheckRange(patience_seconds, 0.1, 60.0, "'patience_seconds'");
  CheckRange(max_apart_seconds, 0.0, 1.0, "'max_apart_seconds'");
  CheckRange(latency_seconds, 0.0, 1.0, "'latency_seconds'");
  if (intrinsics.size() != 4) {
    Throw<ConfigError>(
        "'intrinsics' has {} values; give fx, fy, cx and cy [px] of the images that are sent",
        intrinsics.size());
  }
}

LcmCamera::LcmCamera(const LcmCameraConfig& config, std::shared_ptr<LcmLink> link,
                     const Clock* clock)
    : config_(config), link_(std::move(link)), clock_(clock) {
  config_.Validate();
  info_ = InfoOf(config_);
  inbox_ = std::make_shared<Inbox>(config_, info_, clock_);
  transport::Intake intake = IntakeOf(info_.model);
  intake.on_reject = [inbox = inbox_](const std::string& why) { inbox->Reject(why); };
  link_->Listen(config_.channel, std::move(intake),
                [inbox = inbox_](const auto& message) { inbox->Receive(message); });
  if (!inbox_->Take(Seconds(config_.patience_seconds))) ThrowLost();
}

LcmCamera::~LcmCamera() = default;

std::optional<RgbdFrame> LcmCamera::Grab(Duration timeout) {
  const Duration left = std::max(inbox_->PatienceLeft(), Duration::zero());
  std::optional<RgbdFrame> frame = inbox_->Take(std::min(timeout, left));
  if (!frame && inbox_->PatienceLeft() <= Duration::zero()) ThrowLost();
  return frame;
}

void LcmCamera::ThrowLost() const {
  const std::string fault = inbox_->fault();
  if (fault.empty()) {
    Throw<DeviceError>(
        "camera '{}': nothing came on channel '{}' of {} for {} s: is its driver running, and does "
        "it send there? `lcm-spy` shows what is sent",
        config_.name, config_.channel, link_->url(), config_.patience_seconds);
  }
  Throw<DeviceError>("camera '{}': no good frame on channel '{}' for {} s: {}", config_.name,
                     config_.channel, config_.patience_seconds, fault);
}

}  // namespace secondlook::hal
