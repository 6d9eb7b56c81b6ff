#include "apps/make_robot.h"

#include <utility>

#include "sim/scene.h"

namespace secondlook::apps {
namespace {

ReadyRobot Make(const sim::SimConfig& config, std::uint64_t seed) {
  sim::SimulatedRobot simulated =
      sim::MakeSimulatedRobot(sim::LoadScene(config.scene), config, seed);
  return {std::move(simulated.world), std::move(simulated.robot), simulated.calibration,
          std::move(simulated.hand)};
}

}  // namespace

ReadyRobot MakeRobot(const RobotConfig& config, std::uint64_t seed) {
  return std::visit([&](const auto& backend) { return Make(backend, seed); }, config);
}

}  // namespace secondlook::apps
