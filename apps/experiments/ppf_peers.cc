#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "apps/experiments/clutter.h"
#include "apps/experiments/experiment.h"
#include "apps/experiments/ppf_peer.h"
#include "apps/experiments/random_scene.h"
#include "apps/mission_config.h"
#include "lib/perception/hypothesise.h"
#include "lib/perception/recognise.h"
#include "lib/world/object_database.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;
using perception::RecognitionModel;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMaxError_m = 0.010;
constexpr double kMaxError_rad = 5.0 * kDegree;
constexpr int kModels = 10;
constexpr int kThings = 7;
constexpr int kPeerPoses = 5;  // of each model, that its ICP refines

/// The ten models, and the peer's training of each.
struct Contest {
  std::vector<sim::SceneObject> objects;
  std::vector<RecognitionModel> models;
  std::vector<PpfPeer> peers;  // one for each of `models`, which they refer to
};

Contest Prepare(const ExperimentOptions& options) {
  const auto database = world::ObjectDatabase::Load(options.models);
  Rng rng(ForkSeed(options.seed, "models"));
  Contest contest;
  contest.objects = DrawObjects(LoadRepertoire(options.models, "").known, kModels, &rng);
  std::vector<world::ObjectModel> drawn;
  for (const sim::SceneObject& object : contest.objects) {
    drawn.push_back(*database.Find(object.name));
  }
  contest.models = perception::TrainModels(world::ObjectDatabase(std::move(drawn)));
  for (const RecognitionModel& model : contest.models) contest.peers.emplace_back(model);
  return contest;
}

/// What an answer is worth.
Json Judge(const std::string& name, const Pose& X_CM, const ClutteredThing& thing,
           const RecognitionModel& model) {
  Json verdict{{"model", name}, {"right", false}, {"printed", false}};
  if (name != thing.name) return verdict;
  const auto within = [&](bool with_color) {
    const auto error = perception::DistanceUpToSymmetry(thing.X_CM, X_CM, model.symmetry,
                                                        model.center_M, with_color);
    return error.translation < kMaxError_m && error.rotation < kMaxError_rad;
  };
  const auto error =
      perception::DistanceUpToSymmetry(thing.X_CM, X_CM, model.symmetry, model.center_M, false);
  // The peer sees no colour: what colour alone tells apart counts as equal.
  verdict["right"] = within(false);
  verdict["printed"] = within(true);
  verdict["error_mm"] = error.translation * 1e3;
  verdict["error_deg"] = error.rotation / kDegree;
  return verdict;
}

/// Our answers: the best hypothesis of all, of the model that is there, and what is beyond doubt.
Json RunOurs(const ClutteredThing& thing, const std::vector<RecognitionModel>& models) {
  const perception::RecogniseConfig config = UnderstandingConfig().recognise;
  const auto detections = perception::Recognise(thing.view, {thing.cluster}, models, config);
  const auto choice = perception::ChooseHypotheses(detections, models, config).front();
  const std::vector<world::Hypothesis>& hypotheses = detections.front().hypotheses;
  const auto judge = [&](const world::Hypothesis& h) {
    return Judge(h.model, h.X_CM, thing, *perception::FindModel(models, h.model));
  };
  Json answers{{"any", nullptr}, {"told", nullptr}, {"sure", nullptr}};
  if (!hypotheses.empty()) answers["any"] = judge(hypotheses.front());
  const auto told = std::find_if(hypotheses.begin(), hypotheses.end(),
                                 [&](const auto& h) { return h.model == thing.name; });
  if (told != hypotheses.end()) answers["told"] = judge(*told);
  if (choice.hypothesis >= 0) answers["sure"] = judge(hypotheses[choice.hypothesis]);
  return answers;
}

/// A way in which the peer can choose among its poses: the highest rating.
struct Rule {
  const char* name;
  double (*rate)(const PeerPose& pose);
};

constexpr std::array<Rule, 3> kRules{{
    {"votes", [](const PeerPose& pose) { return static_cast<double>(pose.votes); }},
    {"vote_share", [](const PeerPose& pose) { return pose.vote_share; }},
    {"residual", [](const PeerPose& pose) { return -pose.residual; }},
}};

/// The peer's answers, by each rule: of all models, and of the model that is there.
Json RunPeer(const ClutteredThing& thing, const Contest& contest) {
  const auto surface_C = perception::OrientCluster(thing.view, 0, thing.cluster);
  struct Best {
    double any = -INFINITY;
    double told = -INFINITY;
  };
  std::array<Best, kRules.size()> best;
  Json answers{{"any", Json::object()}, {"told", Json::object()}};
  for (std::size_t m = 0; m < contest.models.size(); ++m) {
    const RecognitionModel& model = contest.models[m];
    for (const PeerPose& pose : contest.peers[m].Match(surface_C, kPeerPoses)) {
      const Json verdict = Judge(model.name, pose.X_CM, thing, model);
      for (std::size_t r = 0; r < kRules.size(); ++r) {
        const double rating = kRules[r].rate(pose);
        if (rating > best[r].any) {
          best[r].any = rating;
          answers["any"][kRules[r].name] = verdict;
        }
        if (model.name == thing.name && rating > best[r].told) {
          best[r].told = rating;
          answers["told"][kRules[r].name] = verdict;
        }
      }
    }
  }
  return answers;
}

Json RunTrial(const Contest& contest, std::uint64_t seed) {
  Rng rng(ForkSeed(seed, "things"));
  const ClutteredThing thing =
      DrawClutteredThing(DrawObjects(contest.objects, kThings, &rng), seed);
  Json trial{{"seed", seed},
             {"model", thing.name},
             {"visible", thing.visible},
             {"pixels", thing.cluster.pixels.size()},
             {"ours", nullptr},
             {"peer", nullptr}};
  if (thing.cluster.pixels.empty()) return trial;
  trial["ours"] = RunOurs(thing, contest.models);
  trial["peer"] = RunPeer(thing, contest);
  return trial;
}

/// How many of our answers are right by `verdict`.
int CountRight(const std::vector<Json>& trials, const char* answer, const char* verdict) {
  return static_cast<int>(std::count_if(trials.begin(), trials.end(), [&](const Json& trial) {
    if (trial.at("ours").is_null() || trial.at("ours").at(answer).is_null()) return false;
    return trial.at("ours").at(answer).at(verdict).get<bool>();
  }));
}

/// How many of the peer's are, by the rule that has most.
int CountRightOfPeer(const std::vector<Json>& trials, const char* answer, const char* verdict) {
  int most = 0;
  for (const Rule& rule : kRules) {
    const auto right = std::count_if(trials.begin(), trials.end(), [&](const Json& trial) {
      if (trial.at("peer").is_null()) return false;
      const Json& answers = trial.at("peer").at(answer);
      return answers.contains(rule.name) && answers.at(rule.name).at(verdict).get<bool>();
    });
    most = std::max(most, static_cast<int>(right));
  }
  return most;
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  const int count = static_cast<int>(trials.size());
  const auto against_peer = [&](const char* metric, const char* answer, const char* verdict) {
    return Row{metric,
               Proportion(CountRight(trials, answer, verdict), count),
               {},
               Proportion(CountRightOfPeer(trials, answer, verdict), count).value};
  };
  const auto sure = static_cast<int>(std::count_if(trials.begin(), trials.end(), [](const Json& t) {
    return !t.at("ours").is_null() && !t.at("ours").at("sure").is_null();
  }));
  std::vector<Row> rows{against_peer("right (10 mm, 5 deg), of ten models", "any", "right"),
                        against_peer("right, told which model it is", "told", "right"),
                        against_peer("right, and its print too", "any", "printed"),
                        {"beyond doubt", Proportion(sure, count)},
                        {"beyond doubt and wrong, of those",
                         Proportion(sure - CountRight(trials, "sure", "right"), sure)}};
  const int peer = CountRightOfPeer(trials, "any", "right");
  if (peer == count) return rows;
  // The interval is that of our failures: the peer's are many more.
  const Estimate failed = Proportion(count - CountRight(trials, "any", "right"), count);
  const double scale = static_cast<double>(count) / (count - peer);
  rows.push_back({"our failures for one of the peer's",
                  {failed.value * scale, failed.low * scale, failed.high * scale}});
  return rows;
}

}  // namespace

void RunPpfPeersExperiment(const ExperimentOptions& options) {
  const Contest contest = Prepare(options);
  RunTrials(
      "ppf-peers", options,
      [&](int t) { return RunTrial(contest, ForkSeed(options.seed, fmt::format("trial {}", t))); },
      Summarise);
}

}  // namespace secondlook::apps
