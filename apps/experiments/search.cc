// Whole missions on a crowded table, in which one thing differs: how looks are chosen, or whether
// what is verified stands in the map.

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/mission_courses.h"
#include "apps/experiments/random_scene.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kThings = 8;
/// What a mission may spend; one that leaves something open counts with all of it.
constexpr world::Budget kBudget{.looks = 15, .seconds = 240.0, .metres = 40.0};
void Run(const std::string& name, const ExperimentOptions& options,
         const std::vector<Variant>& variants,
         const std::function<std::vector<Row>(const std::vector<Json>&)>& summarise) {
  spdlog::set_level(spdlog::level::warn);
  const auto database = world::ObjectDatabase::Load(options.models);
  const Repertoire repertoire = LoadRepertoire(options.models, "");
  const CourseSetup setup{.database = &database, .budget = kBudget};
  RunTrials(
      name, options,
      [&](int t) {
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("trial {}", t));
        Rng rng(ForkSeed(seed, name));
        sim::Scene scene = DrawCrowdedTable(DrawObjects(repertoire.known, kThings, &rng), &rng);
        const double side = rng.Uniform(-std::numbers::pi, std::numbers::pi);
        const double distance = rng.Uniform(1.5, 2.2);
        scene.robot.position = {distance * std::cos(side), distance * std::sin(side)};
        scene.robot.yaw_deg = WrapAngle(side + std::numbers::pi) * 180.0 / std::numbers::pi;
        Json result{{"objects", scene.objects.size()}};
        for (const Variant& variant : variants) {
          result["courses"][variant.name] = RunCourse(scene, variant, setup, seed);
        }
        return result;
      },
      summarise);
}

std::vector<Variant> Choosers() {
  std::vector<Variant> choosers{{"McGreavy", {}}, {"expected loss", {}}};
  choosers[0].config.looks.aspect_graph.strategy = "McGreavy";
  choosers[0].config.looks.views.placed = 0;  // its 38 poses alone
  return choosers;
}

std::vector<Variant> Maps() {
  std::vector<Variant> maps{{"verified objects not in the map", {}},
                            {"verified objects in the map", {}}};
  maps[0].config.understanding.known_in_map = false;
  return maps;
}

}  // namespace

void RunSearchExperiment(const ExperimentOptions& options) {
  const std::vector<Variant> choosers = Choosers();
  Run("search", options, choosers, [&](const std::vector<Json>& trials) {
    std::vector<Row> rows;
    AddOutcomes(trials, choosers, &rows);
    const CourseLoss loss{kThings};
    for (const double seconds : {15.0, 30.0, 60.0, 120.0, 240.0}) {
      AddMeans(
          fmt::format("loss after {} s", seconds), trials, choosers,
          [&](const Json& course) { return loss.AfterSeconds(course, seconds); }, &rows);
    }
    for (const double metres : {2.0, 5.0, 10.0}) {
      AddMeans(
          fmt::format("loss after {} m", metres), trials, choosers,
          [&](const Json& course) { return loss.AfterMetres(course, metres); }, &rows);
    }
    AddMeans(
        "mean loss in 120 s", trials, choosers,
        [&](const Json& course) { return loss.Mean(course, 120.0); }, &rows);
    return rows;
  });
}

void RunRecognisedObjectsExperiment(const ExperimentOptions& options) {
  const std::vector<Variant> maps = Maps();
  Run("recognised-objects", options, maps, [&](const std::vector<Json>& trials) {
    std::vector<Row> rows;
    AddOutcomes(trials, maps, &rows);
    return rows;
  });
}

}  // namespace secondlook::apps
