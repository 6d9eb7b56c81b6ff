#include "apps/experiments/look_courses.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kAttempts = 12;

std::vector<double> ValuesOf(const std::vector<Json>& trials, const std::string& chooser,
                             const Measure& measure) {
  std::vector<double> values;
  for (const Json& trial : Begun(trials)) {
    const Json& courses = trial.at("courses");
    if (courses.contains(chooser)) values.push_back(measure(courses.at(chooser)));
  }
  return values;
}

Estimate ShareOf(const std::vector<double>& values) {
  const auto hits = std::count_if(values.begin(), values.end(), [](double v) { return v != 0.0; });
  return Proportion(static_cast<int>(hits), static_cast<int>(values.size()));
}

/// Of no look yet.
Json NewCourse() {
  return {{"findings", Json::array()}, {"stances", Json::array()}, {"seconds", kBudgetSeconds}};
}

double SecondsIn(const Json& course) { return course.at("seconds"); }

}  // namespace

bool BeginWhere(const std::function<bool(const Stance&)>& promising,
                const std::function<bool(const Finding&)>& acceptable, double azimuth,
                double spread, LookTrial* trial, Rng* rng) {
  for (int i = 0; i < kAttempts; ++i) {
    const double side = azimuth + rng->Uniform(-spread, spread);
    const Stance stance = trial->Facing(side, rng->Uniform(1.4, 2.2));
    if (!promising(stance)) continue;
    trial->Begin(stance);
    if (acceptable(trial->Judge(trial->start()))) return true;
  }
  return false;
}

Json Follow(const std::string& chooser, int looks, LookTrial* trial) {
  Json course = NewCourse();
  double seconds = 0.0;
  std::vector<Stance> stances;
  while (static_cast<int>(stances.size()) < looks) {
    const std::vector<world::Look> candidates = trial->Candidates(trial->After(stances), chooser);
    const world::Look* chosen = ChosenOf(candidates);
    if (chosen == nullptr) break;
    seconds += SecondsOf(*chosen);
    stances.push_back(StanceOf(*chosen));
    const Finding finding = trial->Judge(trial->After(stances));
    course["findings"].push_back(ToJson(finding));
    course["stances"].push_back(ToJson(stances.back()));
    if (!finding.verified && !finding.unknown) continue;
    if (finding.right || (finding.unknown && !trial->IsKnown()))
      course["seconds"] = std::min(seconds, kBudgetSeconds);
    break;
  }
  return course;
}

Json FollowOracle(const std::function<bool(const Stance&)>& promising,
                  const std::function<bool(const Finding&)>& good, LookTrial* trial) {
  std::vector<world::Look> looks = PossibleLooks(trial);
  std::stable_sort(looks.begin(), looks.end(),
                   [](const world::Look& a, const world::Look& b) { return a.score > b.score; });
  Json course = NewCourse();
  for (const world::Look& look : looks) {
    const Stance stance = StanceOf(look);
    if (!promising(stance)) continue;
    const Finding finding = trial->FindingAfter(stance);
    if (!good(finding)) continue;
    course["findings"].push_back(ToJson(finding));
    course["stances"].push_back(ToJson(stance));
    course["seconds"] = std::min(SecondsOf(look), kBudgetSeconds);
    break;
  }
  return course;
}

std::vector<world::Look> PossibleLooks(LookTrial* trial) {
  std::vector<world::Look> looks = trial->Candidates(trial->start(), kOurs);
  std::erase_if(looks, [](const world::Look& look) { return look.path_W.empty(); });
  return looks;
}

Json ToJson(const Finding& finding) {
  return {{"verified", finding.verified}, {"right", finding.right},
          {"unknown", finding.unknown},   {"beliefs", Json(finding.beliefs)},
          {"lacks", finding.lacks},       {"reason", finding.reason}};
}

Json ToJson(const Stance& stance) {
  return {stance.X_WB.x, stance.X_WB.y, stance.X_WB.yaw, stance.head.pan, stance.head.tilt};
}

Stance StanceFrom(const Json& json) {
  return {{json.at(0), json.at(1), json.at(2)}, {json.at(3), json.at(4)}};
}

std::vector<Json> Begun(const std::vector<Json>& trials) {
  std::vector<Json> begun;
  for (const Json& trial : trials) {
    if (trial.contains("courses")) begun.push_back(trial);
  }
  return begun;
}

Json LastFinding(const Json& course) {
  const Json& findings = course.at("findings");
  return findings.empty() ? Json(nullptr) : findings.back();
}

void AddShares(const std::string& metric, const std::vector<Json>& trials,
               std::optional<double> paper, const Measure& holds, std::vector<Row>* rows) {
  const auto add = [&](const std::string& chooser) {
    Row row{fmt::format("{}, {}", metric, chooser), ShareOf(ValuesOf(trials, chooser, holds))};
    if (chooser == kOurs) {
      row.paper = paper;
      row.baseline = ShareOf(ValuesOf(trials, kPaper, holds)).value;
    }
    rows->push_back(std::move(row));
  };
  for (const char* chooser : kChoosers) add(chooser);
  if (!ValuesOf(trials, kOracle, holds).empty()) add(kOracle);
}

void AddFailures(const std::vector<Json>& trials, std::vector<Row>* rows) {
  std::map<std::string, int> failures;
  int count = 0;
  for (const Json& trial : Begun(trials)) {
    const Json& findings = trial.at("courses").at(kOurs).at("findings");
    ++count;
    ++failures[findings.empty() ? "no look" : findings.at(0).at("lacks").get<std::string>()];
  }
  failures.erase("");
  for (const auto& [lacks, times] : failures) {
    rows->push_back(
        {fmt::format("first look ends with: {}, {}", lacks, kOurs), Proportion(times, count)});
  }
}

void AddSharesWherePossible(const std::string& metric, const std::vector<Json>& trials,
                            const Measure& holds, std::vector<Row>* rows) {
  std::vector<Json> possible;
  for (const Json& trial : Begun(trials)) {
    if (holds(trial.at("courses").at(kOracle)) != 0.0) possible.push_back(trial);
  }
  for (const char* chooser : {kPaper, kOurs}) {
    rows->push_back({fmt::format("{} where some look does, {}", metric, chooser),
                     ShareOf(ValuesOf(possible, chooser, holds))});
  }
}

void AddSeconds(const std::vector<Json>& trials, std::vector<Row>* rows) {
  const std::vector<double> ours = ValuesOf(trials, kOurs, SecondsIn);
  for (const char* chooser : kChoosers) {
    rows->push_back(
        {fmt::format("robot time [s], {}", chooser), Mean(ValuesOf(trials, chooser, SecondsIn))});
  }
  for (const char* chooser : kChoosers) {
    if (chooser == std::string(kOurs)) continue;
    std::vector<double> saved = ValuesOf(trials, chooser, SecondsIn);
    for (std::size_t i = 0; i < saved.size(); ++i) saved[i] -= ours[i];
    rows->push_back(
        {fmt::format("robot time saved against {} [s]", chooser), BootstrappedMean(saved)});
  }
}

Row StartRow(const std::vector<Json>& trials) {
  return {"trials that found a start",
          Proportion(static_cast<int>(Begun(trials).size()), static_cast<int>(trials.size()))};
}

}  // namespace secondlook::apps
