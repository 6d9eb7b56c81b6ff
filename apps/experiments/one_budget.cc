// Whole missions of a robot that can look with its head and with its hand, at a table on which some
// things have twins, some stand behind others, and some are small: every look in one common
// currency, or the papers' planners one after the other.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/appearance.h"
#include "apps/experiments/experiment.h"
#include "apps/experiments/mission_courses.h"
#include "apps/experiments/random_scene.h"
#include "apps/experiments/two_cameras.h"
#include "apps/one_shot_look.h"
#include "lib/common/error.h"
#include "lib/common/rng.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;
using world::Look;
using world::LookWay;

constexpr int kThings = 6;
constexpr int kHidden = 2;
constexpr world::Budget kBudget{.looks = 12, .seconds = 180.0, .metres = 30.0};
constexpr double kEyeHeight_m = 1.25;
constexpr const char* kArm = "sim/robots/arm.urdf";

/// Things that one view may not tell apart: by shape at all, and by print.
const std::vector<std::pair<std::string, std::string>> kTwins{{"block_plain", "block_notched"},
                                                              {"oat_box", "rice_box"}};

/// One of each pair of twins, and others up to kThings.
std::vector<sim::SceneObject> DrawThings(std::vector<sim::SceneObject> known, Rng* rng) {
  std::vector<sim::SceneObject> things;
  for (const auto& [one, other] : kTwins) {
    const std::string& name = rng->Index(2) == 0 ? one : other;
    for (const sim::SceneObject& thing : known) {
      if (thing.name == name) things.push_back(thing);
    }
    std::erase_if(known, [&](const sim::SceneObject& thing) {
      return thing.name == one || thing.name == other;
    });
  }
  const int missing = kThings - static_cast<int>(things.size());
  for (sim::SceneObject& thing : DrawObjects(std::move(known), missing, rng)) {
    things.push_back(std::move(thing));
  }
  return things;
}

sim::Scene DrawMixedScene(const std::vector<sim::SceneObject>& known, std::uint64_t seed) {
  Rng rng(ForkSeed(seed, "one-budget"));
  sim::Scene scene = DrawCrowdedTable(DrawThings(known, &rng), &rng);
  const double side = rng.Uniform(-std::numbers::pi, std::numbers::pi);
  const double distance = rng.Uniform(1.0, 1.6);
  scene.robot.position = {distance * std::cos(side), distance * std::sin(side)};
  scene.robot.yaw_deg = WrapAngle(side + std::numbers::pi) * 180.0 / std::numbers::pi;
  const Eigen::Vector3d p_WEye(scene.robot.position.x(), scene.robot.position.y(), kEyeHeight_m);
  return WithOccluders(std::move(scene), p_WEye, kHidden, seed);
}

/// The feasible look at `target` of this way that scores most; null when there is none.
const Look* BestOf(const std::vector<Look>& looks, int target, LookWay way) {
  const Look* best = nullptr;
  for (const Look& look : looks) {
    if (!look.feasible || look.target != target || look.way != way) continue;
    if (best == nullptr || look.score > best->score) best = &look;
  }
  return best;
}

/// The papers' planners in a fixed order: of the things that are open the first (Hoseini 2018) is
/// looked at by the hand, once, from the side that the one-shot vote says (2021), where it has been
/// classified; then by the head from McGreavy's places, until it is settled or may have no more
/// looks. Space where something may be hidden comes last.
class PapersInOrder {
 public:
  PapersInOrder(const Mission& mission, MissionConfig config,
                const perception::Classifier* classifier)
      : mission_(&mission), config_(std::move(config)), classifier_(classifier) {}

  std::optional<TakenLook> operator()(std::optional<TakenLook> own, const std::string&) const {
    if (!own) return own;
    std::optional<int> first;
    for (const Look& look : own->candidates) {
      if (look.feasible && look.target >= 0 && (!first || look.target < *first)) {
        first = look.target;
      }
    }
    if (!first) return own;  // a search, or hidden space
    std::optional<Look> look;
    if (!HandHasLookedAt(*first)) look = OfHand(own->candidates, *first);
    if (!look) {
      const Look* best = BestOf(own->candidates, *first, LookWay::kHead);
      if (best == nullptr) best = BestOf(own->candidates, *first, LookWay::kArm);
      look = *best;
    }
    for (Look& candidate : own->candidates) candidate.chosen = false;
    look->chosen = true;
    look->reason = fmt::format("object {} is the first that is open", *first);
    own->look = *look;
    return own;
  }

 private:
  bool HandHasLookedAt(int target) const {
    const std::vector<TakenLook>& taken = mission_->record().looks;
    return std::any_of(taken.begin(), taken.end(), [&](const TakenLook& t) {
      return t.look.target == target && t.look.way == LookWay::kArm;
    });
  }

  std::optional<Look> OfHand(const std::vector<Look>& candidates, int target) const {
    std::vector<Look> of_hand = candidates;
    std::erase_if(of_hand, [](const Look& look) { return look.way != LookWay::kArm; });
    if (classifier_ != nullptr) {
      for (const world::ObjectBelief& object : mission_->belief().objects) {
        if (object.id != target) continue;
        const planning::AspectGraphConfig& graph = config_.looks.aspect_graph;
        const std::optional<Look> voted =
            OneShotLook(mission_->belief(), object, mission_->task(), *classifier_,
                        config_.understanding.conclude.view_reliability, graph.loss,
                        graph.look_seconds, of_hand);
        if (voted) return voted;
      }
    }
    const Look* best = BestOf(of_hand, target, LookWay::kArm);
    return best != nullptr ? std::optional<Look>(*best) : std::nullopt;
  }

  const Mission* mission_;
  MissionConfig config_;
  const perception::Classifier* classifier_;
};

/// The papers' planners, and ours.
std::vector<Variant> Variants(const perception::Classifier* classifier) {
  MissionConfig papers;
  papers.looks.aspect_graph.strategy = "McGreavy";
  papers.looks.views.placed = 0;  // the 38 poses alone
  return {{"papers' planners in order", papers,
           [papers, classifier](const Mission& mission) {
             return PapersInOrder(mission, papers, classifier);
           }},
          {"one budget", {}, {}}};
}

}  // namespace

void RunOneBudgetExperiment(const ExperimentOptions& options) {
  spdlog::set_level(spdlog::level::warn);
  const auto database = world::ObjectDatabase::Load(options.models);
  const Repertoire repertoire = LoadRepertoire(options.models, "");
  for (const auto& [one, other] : kTwins) {
    for (const std::string& name : {one, other}) {
      if (std::none_of(repertoire.known.begin(), repertoire.known.end(),
                       [&](const sim::SceneObject& thing) { return thing.name == name; })) {
        Throw<ConfigError>("--models {}: has no '{}'; one-budget needs the twins of sim/models",
                           options.models, name);
      }
    }
  }
  const auto classifier = LoadMissionClassifier(options.classifier, database);
  CourseSetup setup{.database = &database, .budget = kBudget, .classifier = classifier.get()};
  setup.robot.arm.emplace();
  setup.robot.arm->urdf = kArm;
  const std::vector<Variant> variants = Variants(classifier.get());
  RunTrials(
      "one-budget", options,
      [&](int t) {
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("trial {}", t));
        const sim::Scene scene = DrawMixedScene(repertoire.known, seed);
        Json result{{"objects", scene.objects.size()}, {"boxes", scene.boxes.size()}};
        for (const Variant& variant : variants) {
          result["courses"][variant.name] = RunCourse(scene, variant, setup, seed);
        }
        return result;
      },
      [&](const std::vector<Json>& trials) {
        std::vector<Row> rows;
        const CourseLoss loss{kThings};
        for (const double seconds : {60.0, 120.0, 180.0}) {
          AddMeans(
              fmt::format("mean loss in {} s", seconds), trials, variants,
              [&](const Json& course) { return loss.Mean(course, seconds); }, &rows);
        }
        AddOutcomes(trials, variants, &rows);
        return rows;
      });
}

}  // namespace secondlook::apps
