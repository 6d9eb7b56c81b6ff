#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/mission_trial.h"
#include "apps/experiments/random_scene.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector2d;

/// Of its way around the table: so near together that no straight part leads through it.
constexpr double kStep = 20.0 * std::numbers::pi / 180.0;  // [rad]

/// Somebody who walks to and fro around a part of the table, where the robot wants to drive: so
/// slowly at times that they stand there for it.
sim::MovingObstacle DrawWalker(const sim::Scene& scene, int number, Rng* rng) {
  sim::MovingObstacle walker;
  walker.name = fmt::format("person {}", number);
  walker.radius = rng->Uniform(0.2, 0.3);
  walker.speed = rng->Uniform(0.02, 0.8);
  const double distance = rng->Uniform(1.1, 1.7);
  const double start = rng->Uniform(-std::numbers::pi, std::numbers::pi);
  const int steps = 3 + rng->Index(12);
  for (int i = 0; i <= steps; ++i) {
    const double angle = start + i * kStep;
    walker.waypoints.emplace_back(scene.table.position +
                                  distance * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return walker;
}

/// A random scene without crates in which one to three people walk about.
sim::Scene DrawLivelyScene(const Repertoire& repertoire, Rng* rng) {
  sim::Scene scene = DrawScene(repertoire, rng);
  scene.boxes.clear();  // nobody walks through one
  const int people = 1 + rng->Index(3);
  for (int i = 1; i <= people;) {
    const sim::MovingObstacle walker = DrawWalker(scene, i, rng);
    const double gap = (walker.waypoints.front() - scene.robot.position).norm();
    if (gap < 0.8) continue;  // the robot starts there
    scene.moving_obstacles.push_back(walker);
    ++i;
  }
  return scene;
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  const int count = static_cast<int>(trials.size());
  int collided = 0;
  int hung = 0;
  int stated = 0;
  int settled = 0;
  int hindered = 0;
  int hindered_and_settled = 0;
  int known = 0;
  int right = 0;
  int wrong = 0;
  std::vector<double> not_reached;
  std::vector<double> seconds;
  for (const Json& trial : trials) {
    const std::string end = trial.at("end");
    const bool was_hindered = trial.at("not_reached") > 0;
    collided += trial.at("collisions") > 0;
    hung += end == "unfinished";
    stated += end != "unfinished" && trial.at("why") != "";
    settled += end == "settled";
    hindered += was_hindered;
    hindered_and_settled += was_hindered && end == "settled";
    for (const Json& v : trial.at("verdicts")) {
      known += v.at("truth") != "" && v.at("known");
      right += v.at("verdict") == "right";
      wrong += v.at("verdict") == "wrong";
    }
    not_reached.push_back(trial.at("not_reached"));
    seconds.push_back(trial.at("robot_seconds"));
  }
  return {{"missions with a collision", Proportion(collided, count)},
          {"missions that hang", Proportion(hung, count)},
          {"missions with a stated result", Proportion(stated, count)},
          {"missions with everything settled", Proportion(settled, count)},
          {"missions in which a look was not reached", Proportion(hindered, count)},
          {"… of these, with everything settled", Proportion(hindered_and_settled, hindered)},
          {"known objects right", Proportion(right, known)},
          {"verified wrongly, of all verified", Proportion(wrong, right + wrong)},
          {"looks that were not reached", Mean(not_reached)},
          {"robot time [s]", Mean(seconds)}};
}

}  // namespace

void RunMovingObstaclesExperiment(const ExperimentOptions& options) {
  spdlog::set_level(spdlog::level::warn);  // dozens of missions at once tell no one anything
  const auto database = world::ObjectDatabase::Load(options.models);
  const Repertoire repertoire = LoadRepertoire(options.models, options.unfamiliar);
  RunTrials(
      "moving-obstacles", options,
      [&](int t) {
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("moving obstacles {}", t));
        Rng rng(ForkSeed(seed, "scene"));
        const std::filesystem::path report =
            options.report.empty()
                ? ""
                : std::filesystem::path(options.report) / fmt::format("trial_{}", t);
        Json result =
            RunMissionTrial(DrawLivelyScene(repertoire, &rng), options, database, seed, report);
        fmt::print(stderr, "trial {}: {}\n", t, result["end"].get<std::string>());
        return result;
      },
      Summarise);
}

}  // namespace secondlook::apps
