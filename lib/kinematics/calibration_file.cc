#include "lib/kinematics/calibration_file.h"

#include <cmath>
#include <numbers>
#include <string>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/yaml_reader.h"

namespace secondlook::kinematics {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kFarthest = 5.0;  // [m] from one part of a robot to the next

/// A transform as the file has it.
struct PoseText {
  Eigen::Vector3d position{0.0, 0.0, 0.0};  // [m]
  Eigen::Vector3d rpy_deg{0.0, 0.0, 0.0};   // Rz(yaw) Ry(pitch) Rx(roll)

  template <class A>
  void Serialize(A* a) {
    a->Visit("position", &position);
    a->Visit("rpy_deg", &rpy_deg);
  }
  void Validate() const {
    if (!(position.norm() <= kFarthest)) {
      Throw<ConfigError>("'position' is farther than {} m, which no robot is: give metres",
                         kFarthest);
    }
    if (!rpy_deg.allFinite()) Throw<ConfigError>("'rpy_deg' is not finite");
  }
};

struct FileText {
  std::optional<PoseText> X_BH0;
  std::optional<PoseText> X_HC;
  std::optional<PoseText> X_EC;
  std::optional<PoseText> X_EL;
  std::optional<CalibrationResiduals> residuals;
  std::optional<CalibrationResiduals> hand_residuals;

  template <class A>
  void Serialize(A* a) {
    a->Visit("X_BH0", &X_BH0);
    a->Visit("X_HC", &X_HC);
    a->Visit("X_EC", &X_EC);
    a->Visit("X_EL", &X_EL);
    a->Visit("residuals", &residuals);
    a->Visit("hand_residuals", &hand_residuals);
  }
  void Validate() const {
    if (!X_BH0) Throw<ConfigError>("'X_BH0' is missing: the pan-tilt head's mount in the base");
    if (!X_HC) Throw<ConfigError>("'X_HC' is missing: the camera in the pan-tilt head");
  }
};

Pose ToPose(const PoseText& text) {
  const Eigen::Vector3d rpy = text.rpy_deg * kDegree;
  Pose X_AB = Pose::Identity();
  X_AB.translation() = text.position;
  X_AB.linear() = RotationFromRollPitchYaw(rpy.x(), rpy.y(), rpy.z());
  return X_AB;
}

/// With a pitch of at most 90 degrees.
PoseText ToText(const Pose& X_AB) {
  const Eigen::Matrix3d& R = X_AB.linear();
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  const double s = std::sin(yaw);
  const double c = std::cos(yaw);
  const double pitch = std::atan2(-R(2, 0), c * R(0, 0) + s * R(1, 0));
  const double roll = std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1));
  return {X_AB.translation(), Eigen::Vector3d(roll, pitch, yaw) / kDegree};
}

}  // namespace

Calibration LoadCalibration(const std::filesystem::path& file) {
  FileText text;
  ApplyLayer(ReadYamlFile(file), &text);
  Calibration calibration{{ToPose(*text.X_BH0), ToPose(*text.X_HC)}, {}, text.residuals};
  calibration.hand_residuals = text.hand_residuals;
  if (text.X_EC) calibration.X_EC = ToPose(*text.X_EC);
  if (text.X_EL) calibration.X_EL = ToPose(*text.X_EL);
  return calibration;
}

void SaveCalibration(const Calibration& calibration, const std::filesystem::path& file) {
  FileText text;
  text.X_BH0 = ToText(calibration.head.X_BH0);
  text.X_HC = ToText(calibration.head.X_HC);
  text.residuals = calibration.residuals;
  text.hand_residuals = calibration.hand_residuals;
  if (calibration.X_EC) text.X_EC = ToText(*calibration.X_EC);
  if (calibration.X_EL) text.X_EL = ToText(*calibration.X_EL);
  WriteFile(file, ToYaml(text));
}

}  // namespace secondlook::kinematics
