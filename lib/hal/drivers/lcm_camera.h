#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lib/common/clock.h"
#include "lib/hal/camera.h"
#include "lib/hal/drivers/lcm_link.h"

namespace secondlook::hal {

struct LcmCameraConfig {
  static constexpr const char* kTag = "Lcm";

  std::string name{"head"};
  std::string channel{"CAMERA"};  ///< On which its bot_core.images_t come.
  int width{640};
  int height{480};
  std::vector<double> intrinsics;  ///< fx, fy, cx, cy [px] of the undistorted colour; required.
  bool depth{true};                ///< It sends depth, registered to colour, as well.
  double min_depth{0.3};           ///< Nothing nearer is taken for measured [m] …
  double max_depth{5.0};           ///< … nor farther.
  double patience_seconds{1.0};    ///< Without a good frame for so long it is lost.
  double max_apart_seconds{0.02};  ///< Of the stamps of colour and depth in one frame.
  /// Its stamps are by the clock of this machine, or one kept equal to it (NTP, PTP). False: by a
  /// clock of its own, and the quickest message tells how the two stand.
  bool synchronised{true};
  double latency_seconds{0.033};  ///< Unless synchronised: from mid-exposure to arrival, at least.

  template <class A>
  void Serialize(A* a) {
    a->Visit("name", &name);
    a->Visit("channel", &channel);
    a->Visit("width", &width);
    a->Visit("height", &height);
    a->Visit("intrinsics", &intrinsics);
    a->Visit("depth", &depth);
    a->Visit("min_depth", &min_depth);
    a->Visit("max_depth", &max_depth);
    a->Visit("patience_seconds", &patience_seconds);
    a->Visit("max_apart_seconds", &max_apart_seconds);
    a->Visit("synchronised", &synchronised);
    a->Visit("latency_seconds", &latency_seconds);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// Any camera whose images somebody sends over LCM as bot_core.images_t: a RealSense, one that ROS
/// drives. What comes is checked before it is decoded; what is wrong with it is told when no good
/// frame came for too long. A camera that is lost comes back with its next good frame.
class LcmCamera : public Camera {
 public:
  /// Waits for the first frame.
  /// @param link, clock Not null; the clock outlives both this and the link.
  /// @throws ConfigError; DeviceError naming the camera when no good frame came, and why.
  LcmCamera(const LcmCameraConfig& config, std::shared_ptr<LcmLink> link, const Clock* clock);
  ~LcmCamera() override;

  const CameraInfo& info() const override { return info_; }
  std::optional<RgbdFrame> Grab(Duration timeout) override;

 private:
  class Inbox;

  [[noreturn]] void ThrowLost() const;

  const LcmCameraConfig config_;
  const std::shared_ptr<LcmLink> link_;
  const Clock* clock_;
  CameraInfo info_;
  std::shared_ptr<Inbox> inbox_;  ///< The link keeps it, too.
};

}  // namespace secondlook::hal
