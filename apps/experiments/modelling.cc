// Things that are in no database, modelled by scans from planned views: how many it takes, by each
// way to plan them.

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/modelling_trial.h"
#include "apps/experiments/random_scene.h"
#include "lib/common/rng.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;
using Measure = std::function<double(const Json& course)>;

/// One that does not get there counts with all of them…
constexpr int kScans = 12;
constexpr double kSeconds = 75.0;  ///< …and as much time as they take at most.
/// The share of its surface that a scan must be expected to add, or ours stops.
constexpr double kWorthwhile = 0.01;
constexpr double kEnough = 0.95;

Json ToJson(const ModelledScan& scan) {
  return {{"seconds", scan.seconds},
          {"reached", scan.reached},
          {"whole", scan.whole},
          {"estimated", scan.estimated},
          {"estimated_reached", scan.estimated_reached},
          {"rms_mm", 1000.0 * scan.rms},
          {"density", scan.density},
          {"gain", scan.gain},
          {"refused", scan.refused}};
}

/// The first scan of which `key` is at least `share`, from 0; the last when none is.
int FirstWith(const Json& course, const char* key, double share) {
  int i = 0;
  while (i + 1 < static_cast<int>(course.size()) && course[i].at(key).get<double>() < share) ++i;
  return i;
}

/// Scans until `key` is `share`, all when it never is.
Measure ScansUntil(const char* key, double share) {
  return [=](const Json& course) {
    const int i = FirstWith(course, key, share);
    return course[i].at(key).get<double>() < share ? kScans : i + 1;
  };
}

Measure SecondsUntil(double share) {
  return [=](const Json& course) {
    const Json& scan = course[FirstWith(course, "reached", share)];
    return scan.at("reached").get<double>() < share ? kSeconds : scan.at("seconds").get<double>();
  };
}

Measure Last(const char* key) {
  return [=](const Json& course) { return course.back().at(key).get<double>(); };
}

/// How far an estimate is from the true share, over all scans, in points.
Measure Off(const char* estimate, const char* truth) {
  return [=](const Json& course) {
    double sum = 0.0;
    for (const Json& scan : course) {
      sum += std::abs(scan.at(estimate).get<double>() - scan.at(truth).get<double>());
    }
    return 100.0 * sum / static_cast<double>(course.size());
  };
}

/// Where ours would stop: enough is estimated, or the scan after it is not worth while.
int StopsAt(const Json& course) {
  for (int i = 0; i + 1 < static_cast<int>(course.size()); ++i) {
    if (course[i].at("estimated_reached").get<double>() >= kEnough) return i;
    if (course[i + 1].at("gain").get<double>() < kWorthwhile) return i;
  }
  return static_cast<int>(course.size()) - 1;
}

std::vector<double> ValuesOf(const std::vector<Json>& trials, const std::string& planner,
                             const Measure& measure) {
  std::vector<double> values;
  for (const Json& trial : trials) values.push_back(measure(trial.at("courses").at(planner)));
  return values;
}

/// The mean of each planner, ours with Kriegel's as its baseline, and how much less ours is than
/// each other.
void AddMeans(const std::string& metric, const std::vector<Json>& trials, const Measure& measure,
              std::vector<Row>* rows) {
  const std::string& ours = kScanPlanners.back();
  const std::vector<double> by_ours = ValuesOf(trials, ours, measure);
  for (const std::string& planner : kScanPlanners) {
    Row row{fmt::format("{}, {}", metric, planner), Mean(ValuesOf(trials, planner, measure))};
    if (planner == ours) row.baseline = rows->back().estimate.value;
    rows->push_back(std::move(row));
  }
  for (const std::string& planner : kScanPlanners) {
    if (planner == ours) continue;
    std::vector<double> saved = ValuesOf(trials, planner, measure);
    for (std::size_t i = 0; i < saved.size(); ++i) saved[i] -= by_ours[i];
    rows->push_back(
        {fmt::format("{}, saved against {}", metric, planner), BootstrappedMean(saved)});
  }
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  std::vector<Row> rows;
  if (trials.empty()) return rows;
  for (const double share : {0.75, 0.95}) {
    const std::string of = fmt::format("to {:.0f} % of the reachable surface", 100.0 * share);
    AddMeans("scans " + of, trials, ScansUntil("reached", share), &rows);
    AddMeans("seconds " + of, trials, SecondsUntil(share), &rows);
  }
  AddMeans("scans to an estimated coverage of 75 %", trials, ScansUntil("estimated", 0.75), &rows);
  AddMeans(
      "reachable surface missed in the end", trials,
      [](const Json& course) { return 1.0 - course.back().at("reached").get<double>(); }, &rows);
  AddMeans("RMS error [mm]", trials, Last("rms_mm"), &rows);
  const std::string& ours = kScanPlanners.back();
  const auto add = [&](const std::string& metric, const Measure& measure,
                       std::optional<double> paper = {}) {
    Row row{metric, Mean(ValuesOf(trials, ours, measure))};
    row.paper = paper;
    rows.push_back(row);
  };
  const std::vector<double> scans = ValuesOf(trials, ours, ScansUntil("estimated", 0.75));
  const double worst = *std::max_element(scans.begin(), scans.end());
  rows.push_back(
      {"scans to an estimated coverage of 75 %, worst, ours", {worst, worst, worst}, 15});
  const std::vector<double> truly = ValuesOf(trials, ours, ScansUntil("reached", 0.75));
  const double worst_truly = *std::max_element(truly.begin(), truly.end());
  rows.push_back({"scans to 75 % of the reachable surface, worst, ours",
                  {worst_truly, worst_truly, worst_truly}});
  add("completeness of the whole surface, ours", Last("whole"), 0.741);
  add("RMS error at the end [mm], ours", Last("rms_mm"), 10.6);
  add("ĉ_m off the true share of the whole surface [points], ours", Off("estimated", "whole"));
  add("estimated off the true share of the reachable surface [points], ours",
      Off("estimated_reached", "reached"));
  add("scans until ours stops", [](const Json& course) { return StopsAt(course) + 1.0; });
  add("reachable surface when ours stops",
      [](const Json& course) { return course[StopsAt(course)].at("reached").get<double>(); });
  return rows;
}

}  // namespace

void RunModellingExperiment(const ExperimentOptions& options) {
  spdlog::set_level(spdlog::level::warn);
  const Repertoire repertoire = LoadRepertoire(options.models, options.unfamiliar);
  std::vector<sim::SceneObject> things = repertoire.known;
  things.insert(things.end(), repertoire.unknown.begin(), repertoire.unknown.end());
  RunTrials(
      "modelling", options,
      [&](int t) {
        const sim::SceneObject& thing = things[t % things.size()];
        ModellingTrial trial(thing, ForkSeed(options.seed, fmt::format("trial {}", t)));
        Json result{{"object", thing.name}, {"reachable", trial.reachable()}};
        for (const std::string& planner : kScanPlanners) {
          Json course = Json::array();
          for (const ModelledScan& scan : trial.Follow(planner, kScans)) {
            course.push_back(ToJson(scan));
          }
          result["courses"][planner] = std::move(course);
        }
        return result;
      },
      Summarise);
}

}  // namespace secondlook::apps
