#include "apps/experiments/mission_trial.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include <fmt/format.h>

#include "apps/json_output.h"
#include "apps/mission.h"
#include "apps/mission_message.h"
#include "apps/report.h"
#include "apps/run_config.h"
#include "sim/sim_robot.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

Json OrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

}  // namespace

Json ToJson(const Verdict& verdict) {
  return {{"verdict", ToString(verdict.kind)},
          {"truth", verdict.truth},
          {"known", verdict.known},
          {"belief", verdict.belief},
          {"object", verdict.object},
          {"error_mm", OrNull(verdict.error_m * 1e3)},
          {"error_deg", OrNull(verdict.error_deg)},
          {"height_error_mm", OrNull(verdict.height_error_m * 1e3)},
          {"tilt_error_deg", OrNull(verdict.tilt_error_deg)}};
}

const char* ToString(Progress progress) {
  switch (progress) {
    case Progress::kMore:
      return "unfinished";
    case Progress::kSettled:
      return "settled";
    case Progress::kBudgetSpent:
      return "budget spent";
    case Progress::kNoLook:
      return "no look possible";
    case Progress::kStopped:
      return "stopped";
    case Progress::kFailed:
      return "device failed";
  }
  return "";
}

namespace {

/// A mission takes at most so many steps, whatever its budget: the net under a hang.
constexpr int kMaxSteps = 100;

}  // namespace

Json RunMissionTrial(const sim::Scene& scene, const ExperimentOptions& options,
                     const world::ObjectDatabase& database, std::uint64_t seed,
                     const std::filesystem::path& report) {
  const std::clock_t begin = std::clock();
  sim::SimulatedRobot simulated = sim::MakeSimulatedRobot(scene, {}, seed);
  Story story;
  Publisher publisher(report.empty() ? std::vector<transport::Sink*>{}
                                     : std::vector<transport::Sink*>{&story});
  Mission mission(
      {}, {}, database, simulated.calibration, seed, [] { return false; }, &publisher,
      &simulated.robot);
  RunConfig config;
  std::get<sim::SimConfig>(config.robot).scene = (report / "scene.yaml").string();
  config.models = options.models;
  config.seed = seed;
  const second_look::mission_t start =
      DescribeStart(config, database, simulated.robot.clock->Now());
  publisher.Mission(start);
  Progress progress = Progress::kMore;
  for (int step = 0; step < kMaxSteps && progress == Progress::kMore; ++step) {
    progress = mission.Step();
  }
  Json trial;
  trial["seed"] = seed;
  trial["end"] = ToString(progress);
  trial["why"] = mission.record().end;
  trial["looks"] = mission.record().looks.size();
  trial["not_reached"] = std::count_if(
      mission.record().looks.begin(), mission.record().looks.end(),
      [](const TakenLook& taken) { return taken.look.chosen && taken.outcome != "reached"; });
  trial["robot_seconds"] = mission.record().total_seconds;
  trial["metres"] = mission.record().metres;
  trial["collisions"] = simulated.world->collisions().size();
  trial["processor_seconds"] = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  trial["verdicts"] = Json::array();
  for (const Verdict& verdict : Judge(mission, *simulated.world)) {
    trial.at("verdicts").push_back(ToJson(verdict));
  }
  if (!report.empty()) {
    sim::SaveScene(scene, report / "scene.yaml");
    publisher.Mission(DescribeEnd(start, mission.record(), progress, simulated.robot.clock->Now()));
    WriteReport(config, mission, story, report);
    WriteJson(trial, (report / "trial.json").string());
  }
  return trial;
}

}  // namespace secondlook::apps
