// Whole missions on a crowded table, in which one thing differs: how looks are chosen, or whether
// what is verified stands in the map.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/judge.h"
#include "apps/experiments/random_scene.h"
#include "apps/mission.h"
#include "lib/planning/expected_loss.h"
#include "sim/sim_robot.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kThings = 8;
/// What a mission may spend; one that leaves something open counts with all of it.
constexpr world::Budget kBudget{.looks = 15, .seconds = 240.0, .metres = 40.0};
/// The net under a hang.
constexpr int kMaxSteps = 60;

/// A way to go about it. The one that is compared with the others comes last.
struct Variant {
  std::string name;
  MissionConfig config;
};

/// What the task loses by how things truly are left.
double TrueLoss(const Mission& mission, const sim::World& world) {
  const planning::LossConfig loss;
  double sum = 0.0;
  for (const Verdict& verdict : Judge(mission, world)) {
    switch (verdict.kind) {
      case Verdict::Kind::kRight:
      case Verdict::Kind::kUnknownRight:
        break;
      case Verdict::Kind::kWrong:
        sum += loss.wrong;
        break;
      case Verdict::Kind::kMissed:
      case Verdict::Kind::kUnknownOpen:
        sum += loss.unsettled;
        break;
    }
  }
  return sum;
}

/// A mission: what it took, and `loss`, each [seconds, metres, loss] after a view.
Json RunMission(const sim::Scene& scene, const MissionConfig& config,
                const world::ObjectDatabase& database, std::uint64_t seed) {
  sim::SimulatedRobot simulated = sim::MakeSimulatedRobot(scene, {}, seed);
  Publisher silent;
  world::Task task;
  task.budget = kBudget;
  Mission mission(
      config, task, database, simulated.calibration, seed, [] { return false; }, &silent,
      &simulated.robot);
  Json loss = Json::array();
  Progress progress = Progress::kMore;
  for (int step = 0; step < kMaxSteps && progress == Progress::kMore; ++step) {
    const double seconds = mission.record().total_seconds;
    const double metres = mission.record().metres;
    progress = mission.Step();
    loss.push_back({seconds, metres, TrueLoss(mission, *simulated.world)});
  }
  const bool settled = progress == Progress::kSettled;
  int right = 0;
  int wrong = 0;
  for (const Verdict& verdict : Judge(mission, *simulated.world)) {
    right += verdict.kind == Verdict::Kind::kRight ? 1 : 0;
    wrong += verdict.kind == Verdict::Kind::kWrong ? 1 : 0;
  }
  return {{"settled", settled},
          {"end", mission.record().end},
          {"right", right},
          {"wrong", wrong},
          {"looks", settled ? mission.record().looks.size() : kBudget.looks},
          {"seconds", settled ? mission.record().total_seconds : kBudget.seconds},
          {"metres", mission.record().metres},
          {"collisions", simulated.world->collisions().size()},
          {"loss", std::move(loss)}};
}

/// The loss that stands once `spent` seconds (of = 0) or metres (of = 1) are.
double LossAfter(const Json& course, int of, double spent) {
  double loss = kThings;
  for (const Json& entry : course.at("loss")) {
    if (entry.at(of).get<double>() > spent) break;
    loss = entry.at(2);
  }
  return loss;
}

/// The mean of the loss from the start until `seconds`.
double MeanLoss(const Json& course, double seconds) {
  double sum = 0.0;
  double loss = kThings;
  double since = 0.0;
  for (const Json& entry : course.at("loss")) {
    const double at = std::min(entry.at(0).get<double>(), seconds);
    sum += loss * (at - since);
    since = at;
    loss = entry.at(2);
  }
  return (sum + loss * (seconds - since)) / seconds;
}

using Measure = std::function<double(const Json& course)>;

std::vector<double> ValuesOf(const std::vector<Json>& trials, const std::string& name,
                             const Measure& measure) {
  std::vector<double> values;
  for (const Json& trial : trials) values.push_back(measure(trial.at("courses").at(name)));
  return values;
}

/// The mean by variant, and by how much it is less with the last than with each other.
void AddMeans(const std::string& metric, const std::vector<Json>& trials,
              const std::vector<Variant>& variants, const Measure& measure,
              std::vector<Row>* rows) {
  const std::string& ours = variants.back().name;
  for (const Variant& variant : variants) {
    Row row{fmt::format("{}, {}", metric, variant.name),
            Mean(ValuesOf(trials, variant.name, measure))};
    if (variant.name == ours) row.baseline = rows->back().estimate.value;
    rows->push_back(std::move(row));
  }
  for (const Variant& variant : variants) {
    if (variant.name == ours) continue;
    std::vector<double> saved = ValuesOf(trials, variant.name, measure);
    const std::vector<double> by_ours = ValuesOf(trials, ours, measure);
    for (std::size_t i = 0; i < saved.size(); ++i) saved[i] -= by_ours[i];
    rows->push_back(
        {fmt::format("{}, saved against {}", metric, variant.name), BootstrappedMean(saved)});
  }
}

void Run(const std::string& name, const ExperimentOptions& options,
         const std::vector<Variant>& variants,
         const std::function<std::vector<Row>(const std::vector<Json>&)>& summarise) {
  spdlog::set_level(spdlog::level::warn);
  const auto database = world::ObjectDatabase::Load(options.models);
  const Repertoire repertoire = LoadRepertoire(options.models, "");
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
          result["courses"][variant.name] = RunMission(scene, variant.config, database, seed);
        }
        return result;
      },
      summarise);
}

Measure Of(const char* key) {
  return [key](const Json& course) { return course.at(key).get<double>(); };
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

/// The rows that both experiments have.
std::vector<Row> Common(const std::vector<Json>& trials, const std::vector<Variant>& variants) {
  std::vector<Row> rows;
  AddMeans("looks", trials, variants, Of("looks"), &rows);
  AddMeans("robot time [s]", trials, variants, Of("seconds"), &rows);
  AddMeans("driven [m]", trials, variants, Of("metres"), &rows);
  AddMeans("objects right", trials, variants, Of("right"), &rows);
  AddMeans("verified wrongly", trials, variants, Of("wrong"), &rows);
  AddMeans("collisions", trials, variants, Of("collisions"), &rows);
  return rows;
}

}  // namespace

void RunSearchExperiment(const ExperimentOptions& options) {
  const std::vector<Variant> choosers = Choosers();
  Run("search", options, choosers, [&](const std::vector<Json>& trials) {
    std::vector<Row> rows = Common(trials, choosers);
    for (const double seconds : {15.0, 30.0, 60.0, 120.0, 240.0}) {
      AddMeans(
          fmt::format("loss after {} s", seconds), trials, choosers,
          [&](const Json& course) { return LossAfter(course, 0, seconds); }, &rows);
    }
    for (const double metres : {2.0, 5.0, 10.0}) {
      AddMeans(
          fmt::format("loss after {} m", metres), trials, choosers,
          [&](const Json& course) { return LossAfter(course, 1, metres); }, &rows);
    }
    AddMeans(
        "mean loss in 120 s", trials, choosers,
        [](const Json& course) { return MeanLoss(course, 120.0); }, &rows);
    return rows;
  });
}

void RunRecognisedObjectsExperiment(const ExperimentOptions& options) {
  const std::vector<Variant> maps = Maps();
  Run("recognised-objects", options, maps,
      [&](const std::vector<Json>& trials) { return Common(trials, maps); });
}

}  // namespace secondlook::apps
