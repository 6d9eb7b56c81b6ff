#pragma once

#include <deque>
#include <optional>
#include <string>

#include "lib/common/pose_history.h"
#include "lib/hal/robot.h"
#include "lib/kinematics/eye_in_hand.h"
#include "lib/kinematics/head.h"
#include "lib/world/look.h"

namespace secondlook::apps {

/// A frame and where it was taken from.
struct Capture {
  std::string camera_name;
  hal::RgbdFrame frame;
  hal::CameraModel camera;
  Pose X_WC{Pose::Identity()};  ///< At the frame's time, as localisation and encoders say.
  Eigen::Vector3d p_CB_W{Eigen::Vector3d::Zero()};  ///< From the camera to the base's origin [m].
  /// Of X_WC, where that is known better than after a drive; none: perception::NominalCovariance().
  std::optional<Eigen::Matrix<double, 6, 6>> covariance{};
};

/// The share of pixels that were measured, in [0, 1]; 0 for an empty image.
/// @param depth [height, width] CV_32FC1, z_C [m]; NaN = none.
double ShareWithDepth(const cv::Mat& depth);

/// Takes frames with the camera on the head or in the hand and finds the camera's pose at the time
/// of measurement from the histories of base, head and arm. Of a robot with an arm, what a frame
/// shows of the robot's own body is no measurement.
class Capturer {
 public:
  /// `robot` must outlive this.
  Capturer(hal::Robot* robot, const kinematics::HeadCalibration& calibration);

  /// The robot's arm is this one, and its body moves with it. @pre the robot has an arm.
  void KnowArm(const kinematics::EyeInHand& hand) { hand_ = hand; }

  /// The arm is lost: it is not asked any more, and taken to be where it was last. False when it
  /// has never said where that is.
  bool LoseArm() { return arm_lost_ = !arm_states_.empty(); }

  /// Where the arm is, as it says, or has said last [rad]. @pre the arm is known.
  Eigen::VectorXd ArmNow() const;

  /// Notes where base, head and arm are now. To be called often while they move.
  void Poll();

  /// The next frame that the camera of that way takes from now on, waiting up to `timeout`; empty
  /// when none came. @pre the arm is known, for the hand's.
  /// @throws DeviceError when a device is lost, or when the camera's stamps and those of base, head
  /// and arm do not fit together.
  std::optional<Capture> Take(Duration timeout, world::LookWay way = world::LookWay::kHead);

 private:
  Capture At(const hal::RgbdFrame& frame, const hal::CameraInfo& camera, world::LookWay way) const;
  /// The joint angles at `time`. @throws InvalidArgument when they are not known.
  Eigen::VectorXd ArmAt(Time time) const;

  hal::Robot* robot_;
  kinematics::HeadCalibration calibration_;
  PoseHistory X_WB_;
  PoseHistory X_BC_;
  std::optional<kinematics::EyeInHand> hand_;
  bool arm_lost_{};
  std::deque<hal::ArmState> arm_states_;  // of the last while, by time
};

}  // namespace secondlook::apps
