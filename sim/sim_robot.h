#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "lib/hal/robot.h"
#include "lib/kinematics/head.h"
#include "sim/noise.h"
#include "sim/scene.h"
#include "sim/sim_camera.h"
#include "sim/world.h"

namespace secondlook::sim {

/// The simulated robot in a configuration: `robot: !Sim {scene: sim/scenes/default.yaml}`.
struct SimConfig {
  static constexpr const char* kTag = "Sim";

  std::string scene{"sim/scenes/default.yaml"};  ///< The scene file.
  NoiseConfig noise;                             ///< A scene's own 'noise' goes over it.
  std::string camera_fault{"none"};              ///< none, nan, nothing or lost; see CameraFault.

  template <class A>
  void Serialize(A* a) {
    a->Visit("scene", &scene);
    a->Visit("noise", &noise);
    a->Visit("camera_fault", &camera_fault);
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
  kinematics::HeadCalibration calibration;  ///< Nominal, as a calibration file would say.
};

/// Puts a robot into `scene` (config.scene is not read). All its errors are drawn from `seed`.
/// @throws ConfigError naming the object whose mesh cannot be read, or the wrong noise.
SimulatedRobot MakeSimulatedRobot(const Scene& scene, const SimConfig& config, std::uint64_t seed);

}  // namespace secondlook::sim
