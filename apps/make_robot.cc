#include "apps/make_robot.h"

#include <utility>

#include "apps/real_robot.h"
#include "lib/hal/drivers/live_clock.h"
#include "lib/kinematics/box_of_moved.h"
#include "lib/kinematics/calibration_file.h"
#include "sim/scene.h"
#include "sim/standing_room.h"

namespace secondlook::apps {
namespace {

ReadyRobot Make(const sim::SimConfig& config, std::uint64_t seed) {
  const sim::Scene scene = sim::LoadScene(config.scene);
  sim::SimulatedRobot simulated = sim::MakeSimulatedRobot(scene, config, seed);
  sim::RequireStandingRoom(scene, simulated.world->objects());
  return {std::move(simulated.world), std::move(simulated.robot), simulated.calibration,
          std::move(simulated.hand), simulated.X_EL};
}

ReadyRobot Make(const RealConfig& config, std::uint64_t /*seed*/) {
  ReadyRobot ready;
  const kinematics::Calibration calibration = kinematics::LoadCalibration(config.calibration);
  ready.calibration = calibration.head;
  if (config.arm) ready.hand = LoadArm(*config.arm, calibration);
  const bool striper = config.arm && config.arm->striper;
  if (striper) ready.X_EL = LaserOnArm(calibration);
  ready.robot.clock = std::make_unique<hal::LiveClock>();
  RealDevices devices(config, ready.robot.clock.get());
  // What moves last, so that nothing has been started when something is missing.
  ready.robot.head_camera = devices.OpenCamera();
  if (config.arm) ready.robot.hand_camera = devices.OpenHandCamera();
  if (striper) ready.robot.striper = devices.OpenStriper();
  ready.robot.base = devices.OpenBase();
  ready.robot.head = devices.OpenHead();
  if (config.arm) ready.robot.arm = devices.OpenArm();
  return ready;
}

}  // namespace

ReadyRobot MakeRobot(const RobotConfig& config, std::uint64_t seed) {
  return std::visit([&](const auto& backend) { return Make(backend, seed); }, config);
}

hal::ArmBox BoxOfArm(const ReadyRobot& ready) {
  if (!ready.hand) return {};
  return
      [arm = ready.hand->arm](const Eigen::VectorXd& q) { return kinematics::BoxOfMoved(arm, q); };
}

}  // namespace secondlook::apps
