#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <opencv2/core/mat.hpp>

#include "lib/common/time.h"
#include "lib/geometry/camera_model.h"

namespace secondlook::hal {

using geometry::CameraModel;

/// What a camera is. Constant for its lifetime.
struct CameraInfo {
  std::string name;    ///< What messages call it, e.g. "head".
  CameraModel model;   ///< Of colour and depth alike: depth is registered to colour.
  bool has_depth{};    ///< False: frames carry colour alone.
  double min_depth{};  ///< Nothing nearer is measured [m]; 0 without depth.
  double max_depth{};  ///< Nothing farther is measured [m]; 0 without depth.
};

/// One registered colour + depth capture. Copies share pixels (cv::Mat); no later Grab() ever
/// writes to them.
struct RgbdFrame {
  Time time{};               ///< Mid-exposure, not arrival.
  std::uint64_t sequence{};  ///< Capture count; a gap means dropped frames.
  cv::Mat color;             ///< [height, width] CV_8UC3, RGB order.
  cv::Mat depth;             ///< [height, width] CV_32FC1, z_C [m]; NaN = none. Empty: no depth.
};

/// A camera, colour + depth or colour alone: a real driver, a replayed log or the rendered
/// simulation. Every backend passes tests/hal/camera_contract.h, so rely on what is written here
/// and nothing else. Its pose X_WC(time) is not the camera's business. Threading: one caller
/// thread. A driver may run a capture thread of its own, but no code of ours runs on it.
class Camera {
 public:
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;
  virtual ~Camera() = default;

  virtual const CameraInfo& info() const = 0;

  /// Returns the newest frame not yet returned, waiting up to `timeout` (robot time) for one. Empty
  /// when none came: an ordinary event, so try again. Returned frames strictly increase in `time`
  /// and `sequence`; unread older ones are lost. A zero timeout never waits.
  /// @pre timeout >= 0.
  /// @throws DeviceError naming the camera if the device is lost; it is then of no use.
  virtual std::optional<RgbdFrame> Grab(Duration timeout) = 0;

 protected:
  Camera() = default;
};

}  // namespace secondlook::hal
