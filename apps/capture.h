#pragma once

#include <optional>

#include "lib/common/pose_history.h"
#include "lib/hal/robot.h"
#include "lib/kinematics/head.h"

namespace secondlook::apps {

/// A frame and where it was taken from.
struct Capture {
  hal::RgbdFrame frame;
  hal::CameraModel camera;
  Pose X_WC{Pose::Identity()};  ///< At the frame's time, as localisation and encoders say.
  Eigen::Vector3d p_CB_W{Eigen::Vector3d::Zero()};  ///< From the camera to the base's origin [m].
};

/// The share of pixels that were measured, in [0, 1]; 0 for an empty image.
/// @param depth [height, width] CV_32FC1, z_C [m]; NaN = none.
double ShareWithDepth(const cv::Mat& depth);

/// Takes frames with the camera on the head and finds the camera's pose at the time of measurement
/// from the histories of base and head.
class Capturer {
 public:
  /// `robot` must outlive this.
  Capturer(hal::Robot* robot, const kinematics::HeadCalibration& calibration);

  /// Notes where base and head are now. To be called often while they move.
  void Poll();

  /// The next frame taken from now on, waiting up to `timeout`; empty when none came.
  /// @throws DeviceError when a device is lost, or when the camera's stamps and those of base and
  /// head do not fit together.
  std::optional<Capture> Take(Duration timeout);

 private:
  Capture At(const hal::RgbdFrame& frame) const;

  hal::Robot* robot_;
  kinematics::HeadCalibration calibration_;
  PoseHistory X_WB_;
  PoseHistory X_BC_;
};

}  // namespace secondlook::apps
