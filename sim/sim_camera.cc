#include "sim/sim_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lib/common/error.h"
#include "lib/common/hash.h"
#include "lib/common/rng.h"

namespace secondlook::sim {
namespace {

constexpr Duration kPeriod = Duration(1'000'000'000 / 30);
constexpr Duration kLatency = Seconds(0.03);
constexpr double kMaxStampSigmas = 3.0;

/// When frame `sequence` (1, 2, …) is exposed.
Time ExposureTime(std::uint64_t sequence) {
  return Time(kPeriod * static_cast<Duration::rep>(sequence - 1));
}

hal::CameraInfo MakeInfo(CameraMount mount, bool has_depth) {
  const double focal = 320.0 / std::tan(29.0 / 180.0 * std::numbers::pi);
  const DepthRange range = has_depth ? DepthRange{} : DepthRange{0.0, 0.0};
  return {mount == CameraMount::kHead ? "head" : "hand",
          {640, 480, focal, focal, 319.5, 239.5},
          has_depth,
          range.min,
          range.max};
}

}  // namespace

SimCamera::SimCamera(World* world, CameraMount mount, bool has_depth, CameraFault fault,
                     std::uint64_t seed)
    : world_(world),
      mount_(mount),
      fault_(fault),
      seed_(ForkSeed(seed, mount == CameraMount::kHead ? "camera" : "hand camera")),
      info_(MakeInfo(mount, has_depth)) {}

std::uint64_t SimCamera::Newest() const {
  const Duration since = world_->Now().time_since_epoch() - kLatency;
  if (fault_ == CameraFault::kNothing || since < Duration::zero()) return 0;
  return static_cast<std::uint64_t>(since / kPeriod) + 1;
}

std::optional<hal::RgbdFrame> SimCamera::Grab(Duration timeout) {
  if (fault_ == CameraFault::kLost) {
    Throw<DeviceError>("camera '{}': the device is lost; check its cable and restart (simulated)",
                       info_.name);
  }
  const Time deadline = world_->Now() + timeout;
  while (Newest() <= last_sequence_) {
    if (world_->Now() + World::kStep > deadline) return std::nullopt;
    world_->Step();
  }
  return Take(Newest());
}

hal::RgbdFrame SimCamera::Take(std::uint64_t sequence) {
  if (!renderer_) renderer_ = std::make_unique<SceneRenderer>(*world_, info_.model);
  const WorldState& state = world_->StateAt(ExposureTime(sequence));
  const bool on_head = mount_ == CameraMount::kHead;
  const Pose X_WC = on_head ? world_->CameraPose(state) : world_->HandCameraPose(state);
  const Render clean = renderer_->Draw(X_WC, state);
  if (on_head) {
    world_->Record({sequence, X_WC, state});
  } else {
    world_->RecordHand({sequence, X_WC, state});
  }

  Rng rng(Fnv1a(sequence, seed_));
  const double sigma = world_->noise().stamp_sigma;
  const double late =
      std::clamp(rng.Gaussian(sigma), -kMaxStampSigmas * sigma, kMaxStampSigmas * sigma);
  // A stamp is never ahead of the present, nor behind the frame before.
  const Time stamp = std::clamp(state.time + Seconds(late), last_time_ + Duration(1),
                                std::max(world_->Now(), last_time_ + Duration(1)));
  hal::RgbdFrame frame{stamp, sequence, ColorNoise(clean, world_->noise(), &rng), {}};
  if (info_.has_depth) {
    frame.depth =
        DepthNoise(clean, info_.model, {info_.min_depth, info_.max_depth}, world_->noise(), &rng);
  }
  if (fault_ == CameraFault::kNan && info_.has_depth) {
    frame.depth.setTo(cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  }
  last_sequence_ = sequence;
  last_time_ = stamp;
  return frame;
}

}  // namespace secondlook::sim
