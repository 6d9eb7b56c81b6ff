// The experiments of McGreavy, Kunze and Hawes (2016), Section 5, with other ways to choose the
// next look beside the paper's, all from the same starts and with the same views.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/look_courses.h"
#include "apps/experiments/look_trial.h"
#include "apps/experiments/random_scene.h"
#include "lib/common/error.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kPi = std::numbers::pi;

/// The plinth of sim/scenes/plinth.yaml with `objects` on it.
sim::Scene OnPlinth(std::vector<sim::SceneObject> objects, double size = 0.5) {
  sim::Scene scene;
  scene.name = "plinth";
  scene.table.size = {size, size};
  scene.table.height = 0.95;
  scene.table.solid = true;
  scene.walls.emplace();
  scene.objects = std::move(objects);
  return scene;
}

/// What all trials of one experiment share.
struct Setting {
  std::vector<sim::SceneObject> things;
  std::vector<sim::SceneObject> impostors;  // that no model is known of
  SceneUnderstanding blank;
};

/// A trial of its own seed.
using RunTrial = std::function<Json(int t, const Setting& setting, std::uint64_t seed, Rng* rng)>;

void Run(const std::string& name, const ExperimentOptions& options, const RunTrial& trial,
         const std::function<std::vector<Row>(const std::vector<Json>&)>& summarise) {
  const auto database = world::ObjectDatabase::Load(options.models);
  const Repertoire repertoire = LoadRepertoire(options.models, options.unfamiliar);
  const Setting setting{repertoire.known, repertoire.unknown, {{}, {}, database}};
  RunTrials(
      name, options,
      [&](int t) {
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("trial {}", t));
        Rng rng(ForkSeed(seed, name));
        return trial(t, setting, seed, &rng);
      },
      summarise);
}

sim::SceneObject Turned(sim::SceneObject object, double x, double y, Rng* rng) {
  object.position = {x, y};
  object.yaw_deg = rng->Uniform(-180.0, 180.0);
  return object;
}

/// A start or a look may be from any place.
bool Anywhere(const Stance&) { return true; }

/// A fresh result; it has `courses` once it has found a start.
Json NewResult(const LookTrial& trial) { return {{"object", trial.object().name}}; }

void FollowAll(int looks, LookTrial* trial, Json* result) {
  (*result)["start"] = ToJson(trial->start().stance);
  (*result)["begins"] = ToJson(trial->Judge(trial->start()));
  for (const char* chooser : kChoosers) {
    (*result)["courses"][chooser] = Follow(chooser, looks, trial);
  }
}

double RightAfter(const Json& course, std::size_t looks) {
  const Json& findings = course.at("findings");
  for (std::size_t i = 0; i < std::min(looks, findings.size()); ++i) {
    if (findings[i].at("right").get<bool>()) return 1.0;
  }
  return 0.0;
}

/// The last finding is `key`.
double Ends(const Json& course, const char* key) {
  const Json last = LastFinding(course);
  return !last.is_null() && last.at(key).get<bool>() ? 1.0 : 0.0;
}

double Wrong(const Json& course) {
  return Ends(course, "verified") * (1.0 - Ends(course, "right"));
}

// Experiment 1: an object that the start shows badly.

Json Unobstructed(int, const Setting& setting, std::uint64_t seed, Rng* rng) {
  const sim::SceneObject object = DrawObjects(setting.things, 1, rng).at(0);
  LookTrial trial(OnPlinth({Turned(object, 0.0, 0.0, rng)}), 0, setting.blank, {}, seed);
  Json result = NewResult(trial);
  const auto poor = [](const Finding& finding) { return finding.candidate; };
  if (!BeginWhere(Anywhere, poor, 0.0, kPi, &trial, rng)) return result;
  FollowAll(2, &trial, &result);
  const auto good = [](const Finding& finding) { return finding.right; };
  result["courses"][kOracle] = FollowOracle(Anywhere, good, &trial);
  return result;
}

std::vector<Row> SummariseUnobstructed(const std::vector<Json>& trials) {
  std::vector<Row> rows{StartRow(trials)};
  const auto after = [](std::size_t looks) {
    return [looks](const Json& course) { return RightAfter(course, looks); };
  };
  AddShares("identified after one look", trials, 26.0 / 37.0, after(1), &rows);
  AddShares("identified after two looks", trials, 33.0 / 37.0, after(2), &rows);
  AddShares("verified wrongly", trials, {}, Wrong, &rows);
  AddSharesWherePossible("identified after one look", trials, after(1), &rows);
  AddFailures(trials, &rows);
  AddSeconds(trials, &rows);
  return rows;
}

// Experiment 2: an object that is known, and is to be confirmed from another place.

/// The course of one look, with what that view says of the object by itself.
Json Confirm(const world::Look* look, LookTrial* trial) {
  Json course{{"confirmed", 0.0}, {"probability", 0.0}, {"seconds", kBudgetSeconds}};
  if (look == nullptr) return course;
  const Finding finding = trial->FindingIn(StanceOf(*look));
  course["confirmed"] = finding.right ? 1.0 : 0.0;
  course["probability"] = finding.probability;
  course["lacks"] = finding.lacks;
  course["reason"] = finding.reason;
  course["stances"] = Json::array({ToJson(StanceOf(*look))});
  if (finding.right) course["seconds"] = std::min(SecondsOf(*look), kBudgetSeconds);
  return course;
}

Json Confirmation(int, const Setting& setting, std::uint64_t seed, Rng* rng) {
  const sim::SceneObject object = DrawObjects(setting.things, 1, rng).at(0);
  world::Task task;
  task.confidence = 0.999;  // more than one view can give
  LookTrial trial(OnPlinth({Turned(object, 0.0, 0.0, rng)}), 0, setting.blank, task, seed);
  Json result = NewResult(trial);
  const auto confident = [](const Finding& finding) { return finding.right; };
  if (!BeginWhere(Anywhere, confident, 0.0, kPi, &trial, rng)) return result;
  result["start"] = ToJson(trial.start().stance);
  const double before = trial.Judge(trial.start()).probability;
  result["probability"] = before;
  Json& courses = result["courses"];
  for (const char* chooser : kChoosers) {
    const std::vector<world::Look> looks = trial.Candidates(trial.start(), chooser);
    courses[chooser] = Confirm(ChosenOf(looks), &trial);
  }
  courses[kOracle] = Confirm(nullptr, &trial);
  const auto worth = [](const Json& course) {
    return std::pair(course["confirmed"].get<double>(), course["probability"].get<double>());
  };
  for (const world::Look& look : PossibleLooks(&trial)) {
    Json course = Confirm(&look, &trial);
    if (worth(course) > worth(courses[kOracle])) courses[kOracle] = course;
  }
  for (auto& course : courses) {
    course["rise"] = course["probability"].get<double>() - before;
    course["best rise"] = courses[kOracle]["probability"].get<double>() - before;
  }
  return result;
}

std::vector<Row> SummariseConfirmation(const std::vector<Json>& trials) {
  std::vector<Row> rows{StartRow(trials)};
  const auto key = [](const char* name) {
    return [name](const Json& course) { return course.at(name).get<double>(); };
  };
  AddShares("confirmed again", trials, 1.0, key("confirmed"), &rows);
  AddShares(
      "probability rose", trials, 0.6,
      [](const Json& course) { return course.at("rise") > 0.0 ? 1.0 : 0.0; }, &rows);
  for (const char* chooser : kChoosers) {
    std::vector<double> rises;
    std::vector<double> best;
    for (const Json& trial : Begun(trials)) {
      rises.push_back(trial.at("courses").at(chooser).at("rise"));
      best.push_back(trial.at("courses").at(chooser).at("best rise"));
    }
    Row mean{fmt::format("mean rise of the probability, {}", chooser), Mean(rises)};
    if (chooser == std::string(kOurs)) mean.paper = 0.0365;
    rows.push_back(mean);
    rows.push_back(
        {fmt::format("share of the oracle's rise, {}", chooser), BootstrappedRatio(rises, best)});
  }
  AddSeconds(trials, &rows);
  return rows;
}

// Experiment 3: something stands between the start and the object.

/// The object in the middle of a larger plinth, and an occluder `side` [rad] of it.
sim::Scene WithOccluder(const sim::SceneObject& object, sim::SceneObject occluder, double side,
                        Rng* rng) {
  const auto radius = [](const sim::SceneObject& o) {
    const Eigen::AlignedBox3d box =
        geometry::Bounds(geometry::LoadMesh(o.mesh, geometry::ParseLengthUnit(o.unit)));
    return std::max(box.min().head<2>().norm(), box.max().head<2>().norm());
  };
  const double away = std::min(radius(object) + radius(occluder) + 0.03, 0.28);
  occluder = Turned(occluder, away * std::cos(side), away * std::sin(side), rng);
  return OnPlinth({object, occluder}, 0.7);
}

/// A look that sees so much of the silhouette avoids the occluder.
constexpr double kWhole = 0.95;

/// The paper's cause of failure: from where the object hides the occluder, a look is chosen in the
/// map of that frame alone, and in the map that has a frame from the side, too. The task wants more
/// than these tell.
void AddMemory(const sim::Scene& scene, double side, const Setting& setting, std::uint64_t seed,
               Rng* rng, Json* result) {
  world::Task task;
  task.confidence = 0.999;
  LookTrial trial(scene, 0, setting.blank, task, seed);
  const auto away = [&](double angle) {
    return trial.Facing(side + angle, rng->Uniform(1.4, 2.2));
  };
  for (int attempt = 0; attempt < 4; ++attempt) {
    trial.Begin(away(kPi / 2.0));
    const Knowledge& known = trial.After({away(kPi + rng->Uniform(-kPi / 9.0, kPi / 9.0))});
    if (known.scene.belief().views.size() < 2) continue;
    const world::VoxelSpace last = LookTrial::MapOfLastView(known);
    const std::vector<world::Look> by_all = trial.Candidates(known, kOurs);
    const std::vector<world::Look> by_one = trial.Candidates(known, kOurs, &last);
    if (ChosenOf(by_all) == nullptr || ChosenOf(by_one) == nullptr) continue;
    (*result)["memory"] = {{"all frames", trial.VisibleShare(StanceOf(*ChosenOf(by_all)))},
                           {"one frame", trial.VisibleShare(StanceOf(*ChosenOf(by_one)))}};
    return;
  }
}

/// The share of trials in which a look chosen in the map of `frames` avoids the occluder.
Row MemoryRow(const std::vector<Json>& trials, const char* frames) {
  int avoiding = 0;
  int count = 0;
  for (const Json& trial : trials) {
    if (!trial.contains("memory")) continue;
    ++count;
    if (trial.at("memory").at(frames).get<double>() >= kWhole) ++avoiding;
  }
  return {fmt::format("avoids what the object hides, with the map of {}", frames),
          Proportion(avoiding, count)};
}

Json Occlusion(int, const Setting& setting, std::uint64_t seed, Rng* rng) {
  const std::vector<sim::SceneObject> drawn = DrawObjects(setting.things, 2, rng);
  const double side = rng->Uniform(-kPi, kPi);
  const sim::SceneObject object = Turned(drawn.at(0), 0.0, 0.0, rng);
  const sim::Scene scene = WithOccluder(object, drawn.at(1), side, rng);
  LookTrial trial(scene, 0, setting.blank, {}, seed);
  Json result = NewResult(trial);
  result["occluder"] = drawn.at(1).name;
  const auto hidden = [&](const Stance& stance) { return trial.VisibleShare(stance) < 0.8; };
  const auto poor = [](const Finding& finding) { return finding.candidate; };
  if (!BeginWhere(hidden, poor, side, kPi / 9.0, &trial, rng)) return result;
  FollowAll(1, &trial, &result);
  const auto avoids = [&](const Stance& stance) { return trial.VisibleShare(stance) >= kWhole; };
  const auto good = [](const Finding& finding) { return finding.right; };
  result["courses"][kOracle] = FollowOracle(avoids, good, &trial);
  for (auto& course : result["courses"]) {
    course["avoids"] = 0.0;
    if (course["stances"].empty()) continue;
    const double seen = trial.VisibleShare(StanceFrom(course["stances"][0]));
    course["avoids"] = seen >= kWhole ? 1.0 : 0.0;
  }
  // The same start without the clutter.
  LookTrial empty(OnPlinth({object}, 0.7), 0, setting.blank, {}, seed);
  empty.Begin(trial.start().stance);
  const auto without = empty.Candidates(empty.start(), kOurs);
  const Json there =
      ChosenOf(without) == nullptr ? Json(nullptr) : ToJson(StanceOf(*ChosenOf(without)));
  const Json& ours = result["courses"][kOurs]["stances"];
  result["moves elsewhere"] = ours.empty() || there.is_null() || ours[0] != there;
  AddMemory(scene, side, setting, seed, rng, &result);
  return result;
}

std::vector<Row> SummariseOcclusion(const std::vector<Json>& trials) {
  std::vector<Row> rows{StartRow(trials)};
  AddShares(
      "avoids the occluder", trials, {},
      [](const Json& course) { return course.at("avoids").get<double>(); }, &rows);
  const auto recognises = [](const Json& course) {
    return course.at("avoids").get<double>() * RightAfter(course, 1);
  };
  AddShares("avoids the occluder and recognises", trials, 17.0 / 20.0, recognises, &rows);
  AddSharesWherePossible("avoids the occluder and recognises", trials, recognises, &rows);
  AddFailures(trials, &rows);
  AddShares("verified wrongly", trials, {}, Wrong, &rows);
  AddSeconds(trials, &rows);
  int elsewhere = 0;
  const std::vector<Json> begun = Begun(trials);
  for (const Json& trial : begun) elsewhere += trial.at("moves elsewhere").get<bool>() ? 1 : 0;
  rows.push_back({"another look than without the occluder, expected loss",
                  Proportion(elsewhere, static_cast<int>(begun.size()))});
  Row all = MemoryRow(begun, "all frames");
  const Row one = MemoryRow(begun, "one frame");
  all.baseline = one.estimate.value;
  rows.push_back(std::move(all));
  rows.push_back(one);
  return rows;
}

// Experiment 4: two objects that look the same from the start.

struct Twins {
  const char* one;
  const char* other;
};

constexpr std::array<Twins, 2> kTwins{{{"block_plain", "block_notched"}, {"oat_box", "rice_box"}}};
constexpr double kSure = 0.95;

Json Ambiguity(int t, const Setting& setting, std::uint64_t seed, Rng* rng) {
  const Twins& twins = kTwins[static_cast<std::size_t>(t / 2) % kTwins.size()];
  const std::string truth = t % 2 == 0 ? twins.one : twins.other;
  const std::string other = t % 2 == 0 ? twins.other : twins.one;
  const auto object = std::find_if(setting.things.begin(), setting.things.end(),
                                   [&](const sim::SceneObject& o) { return o.name == truth; });
  if (object == setting.things.end()) {
    Throw<ConfigError>(
        "experiment ambiguity: there is no '{}' among the models; it needs {}, {}, "
        "{} and {}, which sim/models has",
        truth, kTwins[0].one, kTwins[0].other, kTwins[1].one, kTwins[1].other);
  }
  LookTrial trial(OnPlinth({Turned(*object, 0.0, 0.0, rng)}), 0, setting.blank, {}, seed);
  Json result = NewResult(trial);
  const auto ambiguous = [&](const Finding& finding) {
    return !finding.verified && finding.BeliefIn(truth) >= 0.1 && finding.BeliefIn(other) >= 0.1;
  };
  if (!BeginWhere(Anywhere, ambiguous, 0.0, kPi, &trial, rng)) return result;
  FollowAll(1, &trial, &result);
  const auto good = [&](const Finding& finding) { return finding.BeliefIn(truth) >= kSure; };
  result["courses"][kOracle] = FollowOracle(Anywhere, good, &trial);
  for (auto& course : result["courses"]) {
    const Json& findings = course.at("findings");
    const Json beliefs = findings.empty() ? Json::object() : findings.at(0).at("beliefs");
    course["right"] = beliefs.value(truth, 0.0);
    course["wrong"] = beliefs.value(other, 0.0);
  }
  return result;
}

std::vector<Row> SummariseAmbiguity(const std::vector<Json>& trials) {
  std::vector<Row> rows{StartRow(trials)};
  AddShares(
      "sure of one of the two after one look", trials, {},
      [](const Json& course) {
        return std::max(course.at("right"), course.at("wrong")) >= kSure ? 1.0 : 0.0;
      },
      &rows);
  AddShares(
      "sure of the wrong one", trials, {},
      [](const Json& course) { return course.at("wrong") >= kSure ? 1.0 : 0.0; }, &rows);
  for (const char* chooser : kChoosers) {
    std::vector<double> shares;
    for (const Json& trial : Begun(trials)) {
      const Json& course = trial.at("courses").at(chooser);
      const double right = course.at("right");
      const double wrong = course.at("wrong");
      shares.push_back(right + wrong > 0.0 ? right / (right + wrong) : 0.5);
    }
    Row row{fmt::format("share of the right one of both, {}", chooser), Mean(shares)};
    if (chooser == std::string(kOurs)) row.paper = 0.749;
    rows.push_back(std::move(row));
  }
  AddFailures(trials, &rows);
  AddSeconds(trials, &rows);
  return rows;
}

// Beside the paper: things that are in no database, and true ones, as the first view mistakes them.

Json Rejection(int t, const Setting& setting, std::uint64_t seed, Rng* rng) {
  const bool impostor = t % 2 == 0;
  const auto& pool = impostor ? setting.impostors : setting.things;
  if (pool.empty()) {
    Throw<ConfigError>(
        "experiment rejection: there is no unfamiliar object; name their folder "
        "with --unfamiliar");
  }
  const sim::SceneObject object = DrawObjects(pool, 1, rng).at(0);
  LookTrial trial(OnPlinth({Turned(object, 0.0, 0.0, rng)}), 0, setting.blank, {}, seed);
  Json result = NewResult(trial);
  result["impostor"] = impostor;
  const auto open = [](const Finding& finding) { return finding.candidate; };
  if (!BeginWhere(Anywhere, open, 0.0, kPi, &trial, rng)) return result;
  FollowAll(3, &trial, &result);
  return result;
}

std::vector<Row> SummariseRejection(const std::vector<Json>& trials) {
  std::vector<Json> impostors;
  std::vector<Json> true_ones;
  for (const Json& trial : trials) {
    (trial.at("impostor").get<bool>() ? impostors : true_ones).push_back(trial);
  }
  std::vector<Row> rows{StartRow(trials)};
  const auto ends = [](const char* key) {
    return [key](const Json& course) { return Ends(course, key); };
  };
  AddShares("impostors called unknown", impostors, {}, ends("unknown"), &rows);
  AddShares("impostors verified", impostors, {}, ends("verified"), &rows);
  AddShares("true objects called unknown", true_ones, {}, ends("unknown"), &rows);
  AddShares("true objects verified rightly", true_ones, {}, ends("right"), &rows);
  AddFailures(true_ones, &rows);
  AddSeconds(trials, &rows);
  return rows;
}

}  // namespace

void RunRejectionExperiment(const ExperimentOptions& options) {
  Run("rejection", options, Rejection, SummariseRejection);
}

void RunUnobstructedExperiment(const ExperimentOptions& options) {
  Run("unobstructed", options, Unobstructed, SummariseUnobstructed);
}

void RunConfirmationExperiment(const ExperimentOptions& options) {
  Run("confirmation", options, Confirmation, SummariseConfirmation);
}

void RunOcclusionExperiment(const ExperimentOptions& options) {
  Run("occlusion", options, Occlusion, SummariseOcclusion);
}

void RunAmbiguityExperiment(const ExperimentOptions& options) {
  Run("ambiguity", options, Ambiguity, SummariseAmbiguity);
}

}  // namespace secondlook::apps
