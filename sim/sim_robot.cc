#include "sim/sim_robot.h"

#include <cmath>
#include <numbers>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/common/yaml_reader.h"
#include "lib/kinematics/calibration_file.h"
#include "sim/sim_arm.h"
#include "sim/sim_base.h"
#include "sim/sim_clock.h"
#include "sim/sim_pan_tilt.h"
#include "sim/sim_striper.h"

namespace secondlook::sim {
namespace {

constexpr double kCameraHeight = 1.25;  // [m] above the floor
constexpr double kRadians = std::numbers::pi / 180.0;

NoiseConfig NoiseIn(const Scene& scene, const NoiseConfig& base) {
  NoiseConfig noise = base;
  if (!scene.noise.empty()) {
    YamlReader(YAML::Load(scene.noise), "scene '" + scene.name + "'", "noise").Read(&noise);
  }
  noise.Validate();
  return noise;
}

Pose Mounted(const Eigen::Vector3d& position, const Eigen::Vector3d& rpy_deg) {
  Pose X = Pose::Identity();
  X.translation() = position;
  const Eigen::Vector3d rpy = rpy_deg * kRadians;
  X.linear() = RotationFromRollPitchYaw(rpy.x(), rpy.y(), rpy.z());
  return X;
}

}  // namespace

CameraFault ParseCameraFault(const std::string& text) {
  if (text == "none") return CameraFault::kNone;
  if (text == "nan") return CameraFault::kNan;
  if (text == "nothing") return CameraFault::kNothing;
  if (text == "lost") return CameraFault::kLost;
  Throw<ConfigError>("'camera_fault' = '{}' must be none, nan, nothing or lost", text);
}

void SimStriperConfig::Validate() const {
  if (!position.allFinite() || !rpy_deg.allFinite()) {
    Throw<ConfigError>("striper.position and striper.rpy_deg must be finite");
  }
  CheckRange(held, 1, 100'000, "striper.held");
}

void SimArmConfig::Validate() const {
  if (urdf.empty()) Throw<ConfigError>("'urdf' is missing: the file that describes the arm");
  if (!(acceleration_deg > 0.0) || !std::isfinite(acceleration_deg)) {
    Throw<ConfigError>("acceleration_deg = {} must be positive", acceleration_deg);
  }
  if (!camera_position.allFinite() || !camera_rpy_deg.allFinite()) {
    Throw<ConfigError>("camera_position and camera_rpy_deg must be finite");
  }
  if (striper) striper->Validate();
}

ArmSetup LoadArm(const SimArmConfig& config) {
  config.Validate();
  kinematics::Chain chain(kinematics::LoadUrdf(config.urdf), config.tip);
  const auto joints = static_cast<std::size_t>(chain.size());
  if (config.home_deg.size() != joints) {
    Throw<ConfigError>("home_deg has {} angles, but '{}' has {} joints up to '{}'",
                       config.home_deg.size(), config.urdf, joints, config.tip);
  }
  const Pose X_EC = Mounted(config.camera_position, config.camera_rpy_deg);
  ArmSetup setup{{chain.model().name, {}}, {chain, X_EC}, Eigen::VectorXd(chain.size())};
  if (config.striper) {
    setup.striper = {Mounted(config.striper->position, config.striper->rpy_deg),
                     config.striper->held};
  }
  for (int i = 0; i < chain.size(); ++i) {
    const kinematics::Joint& joint = chain.joint(i);
    setup.home[i] = config.home_deg[i] * kRadians;
    if (!(setup.home[i] >= joint.lower && setup.home[i] <= joint.upper)) {
      Throw<ConfigError>("home_deg[{}] = {}, but joint '{}' reaches from {:.1f} to {:.1f} deg", i,
                         config.home_deg[i], joint.name, joint.lower / kRadians,
                         joint.upper / kRadians);
    }
    setup.info.joints.push_back(
        {joint.name, joint.lower, joint.upper, joint.speed, config.acceleration_deg * kRadians});
  }
  return setup;
}

namespace {

/// Lets the robot take `file` for where what it carries sits.
void GoBy(const std::string& file, SimulatedRobot* simulated) {
  const kinematics::Calibration calibration = kinematics::LoadCalibration(file);
  simulated->calibration = calibration.head;
  if (simulated->hand) {
    if (!calibration.X_EC) {
      Throw<ConfigError>("{}: has no X_EC: where the camera sits in the hand", file);
    }
    simulated->hand->X_EC = *calibration.X_EC;
  }
  if (simulated->X_EL && calibration.X_EL) simulated->X_EL = calibration.X_EL;
}

}  // namespace

void SimConfig::Validate() const { ParseCameraFault(camera_fault); }

SimulatedRobot MakeSimulatedRobot(const Scene& scene, const SimConfig& config, std::uint64_t seed) {
  scene.Validate();
  SimulatedRobot simulated;
  simulated.calibration = kinematics::HeadCalibration::AtHeight(kCameraHeight);
  std::optional<ArmSetup> arm;
  if (config.arm) arm = LoadArm(*config.arm);
  simulated.world = std::make_unique<World>(scene, NoiseIn(scene, config.noise),
                                            simulated.calibration, seed, arm);
  World* world = simulated.world.get();
  simulated.robot.clock = std::make_unique<SimClock>(world);
  simulated.robot.base = std::make_unique<SimBase>(world);
  simulated.robot.head = std::make_unique<SimPanTilt>(world);
  simulated.robot.head_camera = std::make_unique<SimCamera>(
      world, CameraMount::kHead, true, ParseCameraFault(config.camera_fault), seed);
  if (arm) {
    simulated.hand = arm->hand;
    simulated.robot.arm = std::make_unique<SimArm>(world);
    simulated.robot.hand_camera = std::make_unique<SimCamera>(
        world, CameraMount::kHand, config.arm->camera_has_depth, CameraFault::kNone, seed);
    if (arm->striper) {
      simulated.X_EL = arm->striper->X_EL;
      simulated.robot.striper = std::make_unique<SimStriper>(world, seed);
    }
  }
  if (!config.calibration.empty()) GoBy(config.calibration, &simulated);
  return simulated;
}

}  // namespace secondlook::sim
