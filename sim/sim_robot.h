#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/hal/robot.h"
#include "lib/kinematics/eye_in_hand.h"
#include "lib/kinematics/head.h"
#include "sim/noise.h"
#include "sim/scene.h"
#include "sim/sim_camera.h"
#include "sim/world.h"

namespace secondlook::sim {

/// The laser striper on the arm's end-effector: how it is mounted, as calibrated (frame L as
/// hal::StriperInfo has it).
struct SimStriperConfig {
  Eigen::Vector3d position{-0.06, 0.0, 0.032};  ///< In E [m].
  Eigen::Vector3d rpy_deg{0.0, 0.0, 0.0};       ///< Rz(yaw) Ry(pitch) Rx(roll).
  int held{100};                                ///< Lines that wait at most to be taken.

  template <class A>
  void Serialize(A* a) {
    a->Visit("position", &position);
    a->Visit("rpy_deg", &rpy_deg);
    a->Visit("held", &held);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// The arm of the simulated robot, with a camera in its hand.
struct SimArmConfig {
  std::string urdf;           ///< Its description; the root link is the base B. Drawn, too.
  std::string tip{"flange"};  ///< The link that is its end-effector E.
  /// Where it begins: of each joint, base to tip. Folded within the base, behind the head's camera.
  std::vector<double> home_deg{80.0, 45.0, 0.0, 112.0, 0.0, -105.0, 120.0};
  double acceleration_deg{150.0};  ///< Limit of every joint [deg/s^2].
  /// The camera in E, as calibrated: x right, y down, z out of the lens.
  Eigen::Vector3d camera_position{0.06, 0.0, 0.032};  ///< [m]
  Eigen::Vector3d camera_rpy_deg{0.0, 0.0, 0.0};      ///< Rz(yaw) Ry(pitch) Rx(roll).
  bool camera_has_depth{true};
  std::optional<SimStriperConfig> striper;  ///< None: it carries no laser.

  template <class A>
  void Serialize(A* a) {
    a->Visit("urdf", &urdf);
    a->Visit("tip", &tip);
    a->Visit("home_deg", &home_deg);
    a->Visit("acceleration_deg", &acceleration_deg);
    a->Visit("camera_position", &camera_position);
    a->Visit("camera_rpy_deg", &camera_rpy_deg);
    a->Visit("camera_has_depth", &camera_has_depth);
    a->Visit("striper", &striper);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// What the files say of the arm that `config` describes.
/// @throws ConfigError for a description that is wrong, or angles that do not fit it.
ArmSetup LoadArm(const SimArmConfig& config);

/// The simulated robot in a configuration: `robot: !Sim {scene: sim/scenes/default.yaml}`.
struct SimConfig {
  static constexpr const char* kTag = "Sim";

  std::string scene{"sim/scenes/default.yaml"};  ///< The scene file.
  NoiseConfig noise;                             ///< A scene's own 'noise' goes over it.
  std::string camera_fault{"none"};              ///< none, nan, nothing or lost; see CameraFault.
  std::optional<SimArmConfig> arm;               ///< None: it has no arm.
  /// The calibration file that the robot goes by; "": the nominal one. Where its cameras and its
  /// laser truly sit does not change by it.
  std::string calibration;

  template <class A>
  void Serialize(A* a) {
    a->Visit("scene", &scene);
    a->Visit("calibration", &calibration);
    a->Visit("noise", &noise);
    a->Visit("camera_fault", &camera_fault);
    a->Visit("arm", &arm);
  }
  /// @throws ConfigError for a fault that there is not.
  void Validate() const;
};

/// Parses "none", "nan", "nothing" or "lost". @throws ConfigError naming `text` otherwise.
CameraFault ParseCameraFault(const std::string& text);

/// A robot and the world that it lives in. The world must outlive the robot, and does.
struct SimulatedRobot {
  std::unique_ptr<World> world;
  hal::Robot robot;
  kinematics::HeadCalibration calibration;    ///< Nominal, or as a calibration file says.
  std::optional<kinematics::EyeInHand> hand;  ///< Likewise; empty: it has no arm.
  std::optional<Pose> X_EL;                   ///< Likewise, of the striper.
};

/// Puts a robot into `scene` (config.scene is not read). All its errors are drawn from `seed`.
/// @throws ConfigError naming the object whose mesh cannot be read, the wrong noise, or what is
/// wrong with the calibration file.
SimulatedRobot MakeSimulatedRobot(const Scene& scene, const SimConfig& config, std::uint64_t seed);

}  // namespace secondlook::sim
