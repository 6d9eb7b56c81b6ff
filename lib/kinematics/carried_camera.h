#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"

namespace secondlook::kinematics {

/// What is seen of a calibration board, whose frame is P.
struct SightedBoard {
  std::vector<Eigen::Vector2d> corners;   ///< Where the board's corners are seen [px] …
  std::vector<Eigen::Vector3d> points_P;  ///< … and which these are [m].
  Pose X_CP{Pose::Identity()};            ///< The board in the camera, by these corners alone.
};

/// One look at a board of a camera C that is fixed to a moving part E of the robot.
struct CarriedView {
  SightedBoard board;
  /// X_BE, when what was measured of it errs by these values. @pre as many as there are sigmas.
  std::function<Pose(const Eigen::VectorXd& correction)> X_BE;
};

/// Where a camera sits, and by what.
struct CarriedCamera {
  Pose X_EC{Pose::Identity()};
  Pose X_BP{Pose::Identity()};  ///< The board, which stands still in B.
  double pixels{};              ///< Left of the corners, root mean square.
  double metres{};              ///< Standard deviation of the place of C in E, the largest …
  double radians{};             ///< … and of its direction, both by the residuals.
};

/// Estimates X_EC and X_BP, from `start`, together with small corrections of every view: those that
/// make the sum of squared residuals of all corners least (Levenberg–Marquardt).
/// @param sigmas By which the corrections of a view are known, each > 0.
/// @throws InvalidArgument for residuals above 2 px, with what to do about it.
CarriedCamera CalibrateCarriedCamera(const std::vector<CarriedView>& views,
                                     const geometry::CameraModel& camera,
                                     const CarriedCamera& start, const Eigen::VectorXd& sigmas);

}  // namespace secondlook::kinematics
