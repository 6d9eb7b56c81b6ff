#include "apps/make_robot.h"

#include <utility>

#include "sim/scene.h"
#include "sim/standing_room.h"

namespace secondlook::apps {
namespace {

ReadyRobot Make(const sim::SimConfig& config, std::uint64_t seed) {
  const sim::Scene scene = sim::LoadScene(config.scene);
  sim::SimulatedRobot simulated = sim::MakeSimulatedRobot(scene, config, seed);
  sim::RequireStandingRoom(scene, simulated.world->objects());
  return {std::move(simulated.world), std::move(simulated.robot), simulated.calibration,
          std::move(simulated.hand)};
}

}  // namespace

ReadyRobot MakeRobot(const RobotConfig& config, std::uint64_t seed) {
  return std::visit([&](const auto& backend) { return Make(backend, seed); }, config);
}

}  // namespace secondlook::apps
