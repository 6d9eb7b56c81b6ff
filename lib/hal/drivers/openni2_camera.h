#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "lib/common/clock.h"
#include "lib/hal/camera.h"
#include "lib/hal/drivers/device_time.h"
#include "lib/hal/drivers/frame_mailbox.h"

namespace secondlook::hal {

struct OpenNi2Config {
  static constexpr const char* kTag = "OpenNi2";

  std::string name{"head"};
  std::string uri;  ///< Of the device, or a recording's file (.oni); empty: the first one there is.
  int width{640};
  int height{480};
  int fps{30};
  /// fx, fy, cx, cy [px] of the colour camera; empty: from the fields of view that the device
  /// tells, which are those of its kind and not of this one.
  std::vector<double> intrinsics;
  double min_depth{0.4};          ///< Nothing nearer is taken for measured [m] …
  double max_depth{5.0};          ///< … nor farther.
  double latency_seconds{0.033};  ///< From mid-exposure to arrival, at the least.

  template <class A>
  void Serialize(A* a) {
    a->Visit("name", &name);
    a->Visit("uri", &uri);
    a->Visit("width", &width);
    a->Visit("height", &height);
    a->Visit("fps", &fps);
    a->Visit("intrinsics", &intrinsics);
    a->Visit("min_depth", &min_depth);
    a->Visit("max_depth", &max_depth);
    a->Visit("latency_seconds", &latency_seconds);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A PrimeSense, Xtion or other camera that OpenNI2 knows, or a recording in its format. Depth is
/// registered to colour by the device. A thread of its own captures; a device that delivers nothing
/// for a second, unplugged or not, is lost, and tried again every second.
class OpenNi2Camera : public Camera {
 public:
  /// Opens the device and waits for its first frame.
  /// @param clock Not null; outlives this.
  /// @throws ConfigError; DeviceError naming the camera and what OpenNI2 says: no device, no such
  /// video mode, no registration, no frames.
  OpenNi2Camera(const OpenNi2Config& config, const Clock* clock);
  ~OpenNi2Camera() override;

  const CameraInfo& info() const override { return info_; }
  std::optional<RgbdFrame> Grab(Duration timeout) override;

 private:
  struct Device;

  void Run();
  void Capture();

  const OpenNi2Config config_;
  const Clock* clock_;
  CameraInfo info_;
  std::unique_ptr<Device> device_;  // of the thread, once that runs
  DeviceTime device_time_;
  std::uint64_t sequence_{};  // of the thread
  FrameMailbox mailbox_;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace secondlook::hal
