#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/make_robot.h"
#include "apps/mission.h"
#include "apps/mission_json.h"
#include "apps/publisher.h"
#include "apps/run_config.h"
#include "lib/common/parallel.h"
#include "lib/world/object_database.h"

namespace secondlook::apps {

/// A mission of a shipped configuration in this process, with all that it lives on.
class SimulatedMission {
 public:
  /// Runs it to its end, or for 100 steps.
  explicit SimulatedMission(const std::vector<std::string>& overrides,
                            std::vector<transport::Sink*> sinks = {},
                            const std::string& config = "config/sim.yaml")
      : config_(LoadRunConfig(config, overrides)),
        threads_(config_.threads),
        database_(LoadDatabase(config_)),
        ready_(MakeRobot(config_.robot, config_.seed)),
        publisher_(std::move(sinks)),
        mission_(
            config_.mission, config_.task, database_, ready_.calibration, config_.seed,
            [] { return false; }, &publisher_, &ready_.robot) {
    if (ready_.hand) mission_.KnowArm(*ready_.hand);
    for (int i = 0; i < 100 && progress_ == Progress::kMore; ++i) progress_ = mission_.Step();
  }

  const Mission& mission() const { return mission_; }
  const sim::World& world() const { return *ready_.world; }
  Progress progress() const { return progress_; }

  /// mission.json as the program writes it.
  std::string Json() const {
    return ToJson(mission_.belief(), mission_.record(), config_.seed).dump(1) + "\n";
  }

 private:
  RunConfig config_;
  ThreadLimit threads_;
  world::ObjectDatabase database_;
  ReadyRobot ready_;
  Publisher publisher_;
  Mission mission_;
  Progress progress_{Progress::kMore};
};

}  // namespace secondlook::apps
