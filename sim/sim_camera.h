#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "lib/hal/camera.h"
#include "sim/scene_renderer.h"
#include "sim/world.h"

namespace secondlook::sim {

/// How a camera can be broken, to see what the mission makes of it.
enum class CameraFault {
  kNone,
  kNan,      ///< Depth is NaN everywhere.
  kNothing,  ///< No frame ever comes.
  kLost,     ///< The device is gone: Grab() throws DeviceError.
};

/// What carries a camera of the simulated robot.
enum class CameraMount { kHead, kHand };

/// A camera of the simulated robot: 640 x 480, 58 x 45 degrees, depth from 0.5 to 6 m, 30 frames a
/// second of robot time, each of which arrives 30 ms after it was exposed. Only a frame that is
/// grabbed gets rendered. Its noise depends on the seed and its sequence number alone.
class SimCamera : public hal::Camera {
 public:
  /// `world` must outlive this, and have an arm for a camera on its hand.
  SimCamera(World* world, CameraMount mount, bool has_depth, CameraFault fault, std::uint64_t seed);

  const hal::CameraInfo& info() const override { return info_; }
  std::optional<hal::RgbdFrame> Grab(Duration timeout) override;

  /// Breaks or mends the camera from now on.
  void SetFault(CameraFault fault) { fault_ = fault; }

 private:
  /// The number of the newest frame that has arrived; 0: none.
  std::uint64_t Newest() const;
  hal::RgbdFrame Take(std::uint64_t sequence);

  World* world_;
  CameraMount mount_;
  CameraFault fault_;
  std::uint64_t seed_;
  hal::CameraInfo info_;
  std::unique_ptr<SceneRenderer> renderer_;  ///< Made for the first frame.
  std::uint64_t last_sequence_{};
  Time last_time_{Duration(-1)};
};

}  // namespace secondlook::sim
