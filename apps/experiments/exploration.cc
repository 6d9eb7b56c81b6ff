// Tables half of whose things are known: how many views, seconds and metres it takes until all are
// recognised or modelled, by each way to choose the scans.

#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/exploration_trial.h"
#include "lib/common/rng.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

/// The rows, and the strategy of each; the last is ours, the one before its baseline.
const std::vector<std::pair<std::string, std::string>> kPlanners{{"random", "random"},
                                                                 {"fixed ring", "fixed step"},
                                                                 {"Kriegel", "Kriegel"},
                                                                 {"ours", "new surface"}};

std::vector<double> ValuesOf(const std::vector<Json>& trials, const std::string& planner,
                             const char* key) {
  std::vector<double> values;
  for (const Json& trial : trials) values.push_back(trial.at("by").at(planner).at(key));
  return values;
}

/// A mean of each planner, and how much less ours is than each other.
void AddMeans(const std::string& metric, const char* key, std::optional<double> paper,
              const std::vector<Json>& trials, std::vector<Row>* rows) {
  const std::string& ours = kPlanners.back().first;
  const std::vector<double> by_ours = ValuesOf(trials, ours, key);
  for (const auto& [planner, strategy] : kPlanners) {
    Row row{fmt::format("{}, {}", metric, planner), Mean(ValuesOf(trials, planner, key)), paper};
    if (planner == ours) row.baseline = rows->back().estimate.value;
    rows->push_back(std::move(row));
  }
  for (const auto& [planner, strategy] : kPlanners) {
    if (planner == ours) continue;
    std::vector<double> saved = ValuesOf(trials, planner, key);
    for (std::size_t i = 0; i < saved.size(); ++i) saved[i] -= by_ours[i];
    rows->push_back(
        {fmt::format("{}, saved against {}", metric, planner), BootstrappedMean(saved)});
  }
}

/// How many of the things that `about` is true of have `key`.
template <class About>
Estimate Share(const std::vector<Json>& trials, const std::string& planner, const char* key,
               const About& about) {
  int of = 0;
  int count = 0;
  for (const Json& trial : trials) {
    for (const Json& thing : trial.at("by").at(planner).at("things")) {
      if (!about(thing)) continue;
      ++of;
      count += thing.at(key).get<bool>() ? 1 : 0;
    }
  }
  return Proportion(count, of);
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  std::vector<Row> rows;
  if (trials.empty()) return rows;
  AddMeans("views until settled", "views", 34, trials, &rows);
  AddMeans("seconds until settled", "robot_seconds", {}, trials, &rows);
  AddMeans("metres until settled", "metres", {}, trials, &rows);
  const auto known = [](const Json& thing) { return thing.at("known").get<bool>(); };
  const auto unknown = [](const Json& thing) {
    return !thing.at("known").get<bool>() && thing.at("truth") != "";
  };
  const auto any = [](const Json&) { return true; };
  for (const auto& [planner, strategy] : kPlanners) {
    int settled = 0;
    int collided = 0;
    for (const Json& trial : trials) {
      settled += trial.at("by").at(planner).at("end") == "settled" ? 1 : 0;
      collided += trial.at("by").at(planner).at("collisions") > 0 ? 1 : 0;
    }
    const auto count = static_cast<int>(trials.size());
    rows.push_back({"settled, " + planner, Proportion(settled, count)});
    rows.push_back({"with a collision, " + planner, Proportion(collided, count)});
    rows.push_back({"known things right, " + planner, Share(trials, planner, "right", known)});
    rows.push_back(
        {"unknown things modelled, " + planner, Share(trials, planner, "modelled", unknown)});
    rows.push_back({"unknown things recognised by their own model, " + planner,
                    Share(trials, planner, "right", unknown)});
    rows.push_back(
        {"taken for what they are not, " + planner, Share(trials, planner, "wrong", any)});
  }
  return rows;
}

}  // namespace

void RunExplorationExperiment(const ExperimentOptions& options) {
  spdlog::set_level(spdlog::level::err);
  RunTrials(
      "exploration", options,
      [&](int t) {
        const HalfKnownTable table = DrawHalfKnownTable(options, t);
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("exploration {}", t));
        Json result{{"scene", table.scene.name}};
        for (const auto& [planner, strategy] : kPlanners) {
          result["by"][planner] = Explore(table, strategy, seed).result;
        }
        return result;
      },
      Summarise);
}

}  // namespace secondlook::apps
