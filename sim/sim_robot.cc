#include "sim/sim_robot.h"

#include "lib/common/yaml_reader.h"
#include "sim/sim_base.h"
#include "sim/sim_clock.h"
#include "sim/sim_pan_tilt.h"

namespace secondlook::sim {
namespace {

constexpr double kCameraHeight = 1.25;  // [m] above the floor

NoiseConfig NoiseIn(const Scene& scene, const NoiseConfig& base) {
  NoiseConfig noise = base;
  if (!scene.noise.empty()) {
    YamlReader(YAML::Load(scene.noise), "scene '" + scene.name + "'", "noise").Read(&noise);
  }
  noise.Validate();
  return noise;
}

}  // namespace

CameraFault ParseCameraFault(const std::string& text) {
  if (text == "none") return CameraFault::kNone;
  if (text == "nan") return CameraFault::kNan;
  if (text == "nothing") return CameraFault::kNothing;
  if (text == "lost") return CameraFault::kLost;
  Throw<ConfigError>("'camera_fault' = '{}' must be none, nan, nothing or lost", text);
}

void SimConfig::Validate() const { ParseCameraFault(camera_fault); }

SimulatedRobot MakeSimulatedRobot(const Scene& scene, const SimConfig& config, std::uint64_t seed) {
  scene.Validate();
  SimulatedRobot simulated;
  simulated.calibration = kinematics::HeadCalibration::AtHeight(kCameraHeight);
  simulated.world =
      std::make_unique<World>(scene, NoiseIn(scene, config.noise), simulated.calibration, seed);
  World* world = simulated.world.get();
  simulated.robot.clock = std::make_unique<SimClock>(world);
  simulated.robot.base = std::make_unique<SimBase>(world);
  simulated.robot.head = std::make_unique<SimPanTilt>(world);
  simulated.robot.head_camera =
      std::make_unique<SimCamera>(world, ParseCameraFault(config.camera_fault), seed);
  return simulated;
}

}  // namespace secondlook::sim
