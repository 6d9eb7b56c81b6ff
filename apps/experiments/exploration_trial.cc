#include "apps/experiments/exploration_trial.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "apps/experiments/judge.h"
#include "apps/experiments/mission_trial.h"
#include "apps/experiments/random_scene.h"
#include "apps/mission.h"
#include "lib/common/rng.h"
#include "sim/sim_robot.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kOfEach = 3;
constexpr int kMaxSteps = 100;  // the net under a hang
constexpr int kLooks = 60;      // the budget

constexpr std::array<std::string_view, 8> kWorkshop{"canister_blue", "canister_red", "connector",
                                                    "hammer",        "oil_filter",   "power_drill",
                                                    "screwdriver",   "valve"};

bool OfTheWorkshop(const sim::SceneObject& object) {
  return std::find(kWorkshop.begin(), kWorkshop.end(), object.name) != kWorkshop.end();
}

/// What truly became of one thing.
Json ToJson(const Verdict& verdict, const std::vector<ModelledThing>& modelled) {
  const auto made = std::find_if(modelled.begin(), modelled.end(), [&](const ModelledThing& thing) {
    return !thing.model.empty() && thing.object == verdict.object;
  });
  const bool own = made != modelled.end() && made->model == verdict.belief;
  Json json{{"truth", verdict.truth}, {"known", verdict.known}, {"belief", verdict.belief}};
  json["right"] = verdict.known ? verdict.kind == Verdict::Kind::kRight : own;
  json["modelled"] = made != modelled.end();
  json["wrong"] = verdict.kind == Verdict::Kind::kWrong && !own;
  if (made == modelled.end()) return json;
  json["scans"] = made->coverage.size();
  json["coverage"] = made->coverage.back();
  json["refused"] = made->refused.size();
  return json;
}

}  // namespace

HalfKnownTable DrawHalfKnownTable(const ExperimentOptions& options, int trial) {
  Rng rng(ForkSeed(options.seed, fmt::format("half-known table {}", trial)));
  const Repertoire repertoire = LoadRepertoire(options.models, options.unfamiliar);
  std::vector<sim::SceneObject> pool = repertoire.known;
  pool.insert(pool.end(), repertoire.unknown.begin(), repertoire.unknown.end());
  std::vector<sim::SceneObject> things = DrawObjects(
      std::move(pool), static_cast<int>(repertoire.known.size() + repertoire.unknown.size()), &rng);
  const bool workshop = trial % 2 == 1;
  std::stable_partition(things.begin(), things.end(), [&](const sim::SceneObject& object) {
    return OfTheWorkshop(object) == workshop;
  });
  things.resize(std::min<std::size_t>(things.size(), 2 * kOfEach));
  HalfKnownTable table;
  for (std::size_t i = 0; i < things.size(); ++i) {
    things[i].role = i % 2 == 0 ? "known" : "unknown";
    if (i % 2 != 0) continue;
    table.database.Add(world::ReadModel(std::filesystem::path(things[i].mesh).parent_path()));
  }
  table.scene = DrawCrowdedTable(things, &rng);
  table.scene.name = workshop ? "workshop" : "household";
  PlaceRobot(&table.scene, &rng);
  return table;
}

Explored Explore(const HalfKnownTable& table, const std::string& strategy, std::uint64_t seed) {
  sim::SimulatedRobot simulated = sim::MakeSimulatedRobot(table.scene, {}, seed);
  Publisher publisher;
  MissionConfig config;
  config.modelling.emplace();
  config.modelling->strategy = strategy;
  world::Task task;
  task.budget.looks = kLooks;
  Mission mission(
      config, task, table.database, simulated.calibration, seed, [] { return false; }, &publisher,
      &simulated.robot);
  Progress progress = Progress::kMore;
  for (int step = 0; step < kMaxSteps && progress == Progress::kMore; ++step) {
    progress = mission.Step();
  }
  const MissionRecord& record = mission.record();
  Explored explored;
  Json& json = explored.result;
  json["end"] = ToString(progress);
  json["why"] = record.end;
  json["views"] = mission.belief().views.size();
  json["scans"] = std::count_if(record.looks.begin(), record.looks.end(),
                                [](const TakenLook& l) { return l.look.kind == "scan"; });
  json["looks"] = record.looks.size();
  json["robot_seconds"] = record.total_seconds;
  json["metres"] = record.metres;
  json["collisions"] = simulated.world->collisions().size();
  json["things"] = Json::array();
  const std::vector<Verdict> verdicts = Judge(mission, *simulated.world);
  for (const Verdict& verdict : verdicts) {
    json["things"].push_back(ToJson(verdict, record.modelled));
  }
  json["modelled"] = Json::array();
  for (const ModelledThing& thing : record.modelled) {
    const auto about = std::find_if(verdicts.begin(), verdicts.end(),
                                    [&](const Verdict& v) { return v.object == thing.object; });
    const std::string truth = about == verdicts.end() ? "" : about->truth;
    json["modelled"].push_back({{"object", thing.object},
                                {"truth", truth},
                                {"model", thing.model},
                                {"coverage", thing.coverage},
                                {"refused", thing.refused},
                                {"reason", thing.reason}});
    if (!thing.model.empty()) explored.models.push_back({truth, AsModel(thing.scanned)});
  }
  return explored;
}

}  // namespace secondlook::apps
