#pragma once

#include <memory>

#include "sim/sim_robot.h"

namespace secondlook::sim {

/// A room with a table in a corner and the robot in the middle, 2.5 m of free floor before it.
inline Scene FreeScene() {
  Scene scene;
  scene.name = "free";
  scene.table.position = {3.0, 2.0};
  scene.floor.size = {10.0, 8.0};
  scene.walls = Walls{};
  scene.robot = {{0.0, 0.0}, 20.0};
  return scene;
}

inline std::shared_ptr<SimulatedRobot> MakeShared(const Scene& scene, const SimConfig& config,
                                                  std::uint64_t seed) {
  return std::make_shared<SimulatedRobot>(MakeSimulatedRobot(scene, config, seed));
}

inline std::shared_ptr<SimulatedRobot> MakeShared(const Scene& scene, const NoiseConfig& noise,
                                                  std::uint64_t seed) {
  SimConfig config;
  config.noise = noise;
  return MakeShared(scene, config, seed);
}

/// Steps until the base has ended its motion.
inline hal::MotionStatus WaitForBase(SimulatedRobot* simulated) {
  while (simulated->robot.base->Status().phase == hal::MotionPhase::kMoving) {
    simulated->world->Step();
  }
  return simulated->robot.base->Status();
}

/// Steps until the head has ended its motion.
inline hal::MotionStatus WaitForHead(SimulatedRobot* simulated) {
  while (simulated->robot.head->Status().phase == hal::MotionPhase::kMoving) {
    simulated->world->Step();
  }
  return simulated->robot.head->Status();
}

}  // namespace secondlook::sim
