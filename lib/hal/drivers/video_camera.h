#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "lib/common/clock.h"
#include "lib/geometry/undistort.h"
#include "lib/hal/camera.h"
#include "lib/hal/drivers/frame_mailbox.h"

namespace secondlook::hal {

struct VideoCameraConfig {
  static constexpr const char* kTag = "Video";

  std::string name{"hand"};
  /// A V4L2 device (/dev/video0), a video file, numbered pictures (img_%04d.png), or a GStreamer
  /// pipeline that ends in appsink.
  std::string source{"/dev/video0"};
  int width{640};  ///< A device is asked for this size; whatever comes must have it.
  int height{480};
  double fps{30.0};                ///< Likewise; a file is played at this rate.
  std::vector<double> intrinsics;  ///< fx, fy, cx, cy [px]; required.
  std::vector<double> distortion;  ///< k1, k2, p1, p2, k3 in OpenCV's meaning; empty: none.
  double latency_seconds{0.05};    ///< From mid-exposure to arrival.

  template <class A>
  void Serialize(A* a) {
    a->Visit("name", &name);
    a->Visit("source", &source);
    a->Visit("width", &width);
    a->Visit("height", &height);
    a->Visit("fps", &fps);
    a->Visit("intrinsics", &intrinsics);
    a->Visit("distortion", &distortion);
    a->Visit("latency_seconds", &latency_seconds);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A colour camera that OpenCV's VideoCapture can read. Its frames are undistorted when they are
/// grabbed. A thread of its own captures; a device that ends, unplugged or not, is lost, and tried
/// again every second. A file that has ended is lost for good.
class VideoCamera : public Camera {
 public:
  /// Opens the source and takes a first frame.
  /// @param clock Not null; outlives this.
  /// @throws ConfigError; DeviceError naming the camera and the source: it cannot be opened, has no
  /// frame, or one of another size.
  VideoCamera(const VideoCameraConfig& config, const Clock* clock);
  ~VideoCamera() override;

  const CameraInfo& info() const override { return info_; }
  std::optional<RgbdFrame> Grab(Duration timeout) override;

 private:
  struct Source;

  void Run();

  const VideoCameraConfig config_;
  const Clock* clock_;
  CameraInfo info_;
  geometry::LensDistortion lens_;
  std::unique_ptr<Source> source_;  // of the thread, once that runs
  std::uint64_t sequence_{};        // likewise
  FrameMailbox mailbox_;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace secondlook::hal
