#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/mission_trial.h"
#include "apps/experiments/random_scene.h"
#include "lib/world/object_database.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  int known = 0;
  int unknown = 0;
  int right = 0;
  int wrong = 0;
  int unknown_right = 0;
  int unfinished = 0;
  int settled = 0;
  int with_collision = 0;
  std::vector<double> looks;
  std::vector<double> seconds;
  std::vector<double> metres;
  std::vector<double> error_mm;
  std::vector<double> error_deg;
  std::vector<double> height_error_mm;
  std::vector<double> tilt_error_deg;
  for (const Json& trial : trials) {
    for (const Json& v : trial.at("verdicts")) {
      const std::string kind = v.at("verdict");
      if (v.at("truth") != "") ++(v.at("known") ? known : unknown);
      if (kind == "right") ++right;
      if (kind == "wrong") ++wrong;
      if (kind == "unknown right") ++unknown_right;
      if (kind != "right") continue;
      error_mm.push_back(v.at("error_mm"));
      error_deg.push_back(v.at("error_deg"));
      height_error_mm.push_back(v.at("height_error_mm"));
      tilt_error_deg.push_back(v.at("tilt_error_deg"));
    }
    const std::string end = trial.at("end");
    if (end == "unfinished") ++unfinished;
    if (end == "settled") ++settled;
    if (trial.at("collisions") > 0) ++with_collision;
    looks.push_back(trial.at("looks"));
    seconds.push_back(trial.at("robot_seconds"));
    metres.push_back(trial.at("metres"));
  }
  const int count = static_cast<int>(trials.size());
  return {{"known objects right", Proportion(right, known)},
          {"verified wrongly, of all verified", Proportion(wrong, right + wrong)},
          {"unknown objects called unknown", Proportion(unknown_right, unknown)},
          {"missions with everything settled", Proportion(settled, count)},
          {"missions with a collision", Proportion(with_collision, count)},
          {"missions that hang", Proportion(unfinished, count)},
          {"looks", Mean(looks)},
          {"robot time [s]", Mean(seconds)},
          {"driven [m]", Mean(metres)},
          {"position error of right ones, camera frame [mm]", Mean(error_mm)},
          {"rotation error of right ones, camera frame [deg]", Mean(error_deg)},
          {"height error of right ones, plane frame [mm]", Mean(height_error_mm)},
          {"tilt error of right ones, plane frame [deg]", Mean(tilt_error_deg)}};
}

}  // namespace

void RunMissionsExperiment(const ExperimentOptions& options) {
  spdlog::set_level(spdlog::level::warn);  // dozens of missions at once tell no one anything
  const auto database = world::ObjectDatabase::Load(options.models);
  const Repertoire repertoire = LoadRepertoire(options.models, options.unfamiliar);
  std::optional<sim::Scene> fixed;
  if (!options.scene.empty()) fixed = sim::LoadScene(options.scene);
  RunTrials(
      "missions", options,
      [&](int t) {
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("trial {}", t));
        Rng rng(ForkSeed(seed, "scene"));
        const sim::Scene scene = fixed ? *fixed : DrawScene(repertoire, &rng);
        const std::filesystem::path report =
            options.report.empty()
                ? ""
                : std::filesystem::path(options.report) / fmt::format("trial_{}", t);
        Json result = RunMissionTrial(scene, options, database, seed, report);
        fmt::print(stderr, "trial {}: {}\n", t, result["end"].get<std::string>());
        return result;
      },
      Summarise);
}

}  // namespace secondlook::apps
