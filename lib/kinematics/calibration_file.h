#pragma once

#include <filesystem>
#include <optional>

#include "lib/common/pose.h"
#include "lib/kinematics/head.h"

namespace secondlook::kinematics {

/// How well a calibration explains the views that it was estimated from.
struct CalibrationResiduals {
  int views{};           ///< That it rests on.
  double pixels{};       ///< Of the board's corners, root mean square.
  double millimetres{};  ///< Standard deviation of the camera's place on what carries it …
  double degrees{};      ///< … and of its direction, by the residuals.

  template <class A>
  void Serialize(A* a) {
    a->Visit("views", &views);
    a->Visit("pixels", &pixels);
    a->Visit("millimetres", &millimetres);
    a->Visit("degrees", &degrees);
  }
};

/// The extrinsics of a robot: what a calibration file holds (docs/real_robot.md).
struct Calibration {
  HeadCalibration head;
  std::optional<Pose> X_EC;  ///< Of a camera in the hand, in the end-effector E.
  std::optional<CalibrationResiduals> residuals;  ///< Of X_HC.
  std::optional<Pose> X_EL{};                     ///< Of a laser striper on the end-effector.
  std::optional<CalibrationResiduals> hand_residuals{};  ///< Of X_EC.
};

/// @throws ConfigError naming the file and the transform that is missing or none.
Calibration LoadCalibration(const std::filesystem::path& file);

/// Writes what LoadCalibration() reads. @throws ConfigError when that cannot be written.
void SaveCalibration(const Calibration& calibration, const std::filesystem::path& file);

}  // namespace secondlook::kinematics
