#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/confusion.h"
#include "apps/experiments/experiment.h"
#include "apps/experiments/random_scene.h"
#include "apps/experiments/two_cameras.h"
#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/fusion/decision_fusion.h"
#include "lib/fusion/dempster_shafer.h"
#include "lib/perception/appearance/feature_classifier.h"

namespace secondlook::apps {
namespace {

using fusion::FusionRule;
using fusion::ViewDecision;
using Json = nlohmann::ordered_json;

constexpr int kThings = 8;
/// Where the first view's largest probability is so many times the second, the paper's system asks
/// for no second.
constexpr double kGate = 10.0;
constexpr std::array kConditions{"plain", "occluded"};

/// Which of two things that look alike on purpose takes no part: no picture tells them apart.
const std::set<std::string> kTwins{"block_notched"};

struct PaperFigures {
  double head;
  double fused;
};

/// Hoseini 2018, Tables 1 and 2: accuracy, precision, recall, F1.
constexpr std::array<std::array<PaperFigures, 4>, 2> kPaper{
    {{{{0.777, 0.972}, {0.834, 0.975}, {0.777, 0.975}, {0.804, 0.975}}},
     {{{0.555, 0.916}, {0.555, 0.933}, {0.533, 0.916}, {0.543, 0.924}}}}};

/// The classes of the classifier, and of the scene's things.
struct Classes {
  std::vector<std::string> all;     ///< Of the classifier, by which probabilities count.
  std::vector<std::string> things;  ///< By which confusion matrices count.

  /// A class of things; none for the background.
  int LabelOf(const std::string& c) const {
    const auto found = std::find(things.begin(), things.end(), c);
    return found == things.end() ? ConfusionMatrix::kBackground
                                 : static_cast<int>(found - things.begin());
  }
};

/// The classifier's probabilities as masses; that of "unknown" is m(Omega) (Hoseini 2018, 2.2).
ViewDecision DecisionOf(const Sighted& sighted, const Classes& classes) {
  ViewDecision decision;
  decision.masses.omega = 0.0;
  for (std::size_t c = 0; c < classes.all.size(); ++c) {
    if (classes.all[c] == perception::kUnknownClass) {
      decision.masses.omega = sighted.probabilities[c];
    } else {
      decision.masses.singletons[classes.all[c]] = sighted.probabilities[c];
    }
  }
  return decision;
}

/// What was said of something: what it truly is, and what it was called.
struct Said {
  int thing{};  ///< -1: nothing.
  std::string c;
};

/// A table under one condition, and what was seen of it.
struct Scene {
  std::vector<int> labels;  ///< Of the things that stand there.
  TwoViews views;
};

/// What a way to decide says of a scene.
using Decider = std::function<std::vector<Said>(const Scene&)>;

std::string Fused(FusionRule rule, const std::vector<ViewDecision>& views) {
  return fusion::MostProbable(FuseDecisions(rule, views).probabilities);
}

std::vector<Said> Alone(const std::vector<Sighted>& sighted, const Classes& classes) {
  std::vector<Said> said;
  for (const Sighted& one : sighted) {
    said.push_back({one.thing, Fused(FusionRule::kAveraging, {DecisionOf(one, classes)})});
  }
  return said;
}

/// Both views of what was matched, the one view of all else.
std::vector<Said> Together(const Scene& scene, const Classes& classes, FusionRule rule,
                           double gate) {
  std::vector<Said> said = Alone(scene.views.head, classes);
  const std::vector<Said> hand = Alone(scene.views.hand, classes);
  std::vector<bool> matched(hand.size(), false);
  for (const fusion::CrossMatch& match : scene.views.matches) {
    const auto box = static_cast<std::size_t>(match.box);
    const auto object = static_cast<std::size_t>(match.object);
    matched[box] = true;
    const ViewDecision first = DecisionOf(scene.views.head[object], classes);
    const auto alone = FuseDecisions(FusionRule::kAveraging, {first}).probabilities;
    if (!(fusion::ConfidenceRatio(alone) < gate)) continue;
    said[object].c = Fused(rule, {first, DecisionOf(scene.views.hand[box], classes)});
    if (said[object].thing < 0) said[object].thing = hand[box].thing;
  }
  for (std::size_t i = 0; i < hand.size(); ++i) {
    if (!matched[i]) said.push_back(hand[i]);
  }
  return said;
}

/// Each thing counts once, rightly when anything that was said of it is right.
ConfusionMatrix Judge(const Scene& scene, std::vector<Said> said, const Classes& classes) {
  ConfusionMatrix matrix(static_cast<int>(classes.things.size()));
  std::erase_if(said, [&](const Said& s) { return classes.LabelOf(s.c) < 0; });
  for (int thing = 0; thing < std::ssize(scene.labels); ++thing) {
    const int truth = scene.labels[static_cast<std::size_t>(thing)];
    const auto of_it = [&](const Said& s) { return s.thing == thing; };
    auto best = std::find_if(said.begin(), said.end(), [&](const Said& s) {
      return of_it(s) && classes.LabelOf(s.c) == truth;
    });
    if (best == said.end()) best = std::find_if(said.begin(), said.end(), of_it);
    if (best == said.end()) {
      matrix.Add(truth, ConfusionMatrix::kBackground);
      continue;
    }
    matrix.Add(truth, classes.LabelOf(best->c));
    said.erase(best);
  }
  for (const Said& s : said) matrix.Add(ConfusionMatrix::kBackground, classes.LabelOf(s.c));
  return matrix;
}

Json ToJson(const std::vector<Sighted>& sighted) {
  Json json = Json::array();
  for (const Sighted& one : sighted) {
    Json rounded = Json::array();
    for (const double p : one.probabilities) rounded.push_back(std::round(p * 1e5) * 1e-5);
    json.push_back({{"thing", one.thing}, {"p", rounded}});
  }
  return json;
}

Json ToJson(const TwoViews& views) {
  Json matches = Json::array();
  for (const fusion::CrossMatch& match : views.matches) {
    matches.push_back({match.object, match.box});
  }
  return {{"head", ToJson(views.head)}, {"hand", ToJson(views.hand)}, {"matches", matches}};
}

std::vector<Sighted> ReadSighted(const Json& json) {
  std::vector<Sighted> sighted;
  for (const Json& one : json) {
    Sighted& s = sighted.emplace_back();
    s.thing = one.at("thing");
    s.probabilities = one.at("p").get<std::vector<double>>();
    double sum = 0.0;  // rounding leaves them not summing to 1 exactly
    for (const double p : s.probabilities) sum += p;
    for (double& p : s.probabilities) p /= sum;
  }
  return sighted;
}

Scene ReadScene(const Json& trial, const std::string& condition, const Classes& classes) {
  Scene scene;
  for (const Json& name : trial.at("things")) {
    scene.labels.push_back(classes.LabelOf(name.get<std::string>()));
  }
  const Json& views = trial.at(condition);
  scene.views.head = ReadSighted(views.at("head"));
  scene.views.hand = ReadSighted(views.at("hand"));
  for (const Json& match : views.at("matches")) {
    scene.views.matches.push_back({match.at(0), match.at(1), 0.0});
  }
  return scene;
}

struct NamedDecider {
  std::string name;
  Decider decide;
};

std::vector<NamedDecider> Deciders(const Classes& classes) {
  const auto together = [&classes](FusionRule rule, double gate) {
    return
        [&classes, rule, gate](const Scene& scene) { return Together(scene, classes, rule, gate); };
  };
  constexpr double kAlways = std::numeric_limits<double>::infinity();
  return {
      {"head alone", [&classes](const Scene& s) { return Alone(s.views.head, classes); }},
      {"hand alone", [&classes](const Scene& s) { return Alone(s.views.hand, classes); }},
      {"fused, averaging", together(FusionRule::kAveraging, kAlways)},
      {"fused, naive Bayes", together(FusionRule::kNaiveBayes, kAlways)},
      {"fused, belief masses", together(FusionRule::kTransferableBelief, kAlways)},
      {fmt::format("fused where the ratio is below {}, belief masses", kGate),
       together(FusionRule::kTransferableBelief, kGate)},
  };
}

ConfusionMatrix Sum(const std::vector<ConfusionMatrix>& matrices, const std::vector<int>& drawn) {
  ConfusionMatrix sum(static_cast<int>(matrices.front().counts().rows()) - 1);
  for (const int i : drawn) sum += matrices[static_cast<std::size_t>(i)];
  return sum;
}

/// How far two views disagree.
using Disagreement = double (*)(const world::MassFunction& a, const world::MassFunction& b);

double MassOfConflict(const world::MassFunction& a, const world::MassFunction& b) {
  return fusion::Combine(a, b).conflict;
}

/// Of pairs of views: of the same thing, and of things of different classes.
struct Conflicts {
  std::vector<double> right;
  std::vector<double> wrong;
};

Conflicts DrawConflicts(const std::vector<Scene>& scenes, const Classes& classes,
                        Disagreement disagreement) {
  constexpr int kDraws = 1000;
  struct View {
    int label;
    ViewDecision decision;
  };
  std::vector<View> hands;
  std::vector<std::pair<View, ViewDecision>> pairs;
  for (const Scene& scene : scenes) {
    const auto label = [&](const Sighted& s) {
      return s.thing < 0 ? -1 : scene.labels[static_cast<std::size_t>(s.thing)];
    };
    for (const Sighted& one : scene.views.hand) {
      if (one.thing >= 0) hands.push_back({label(one), DecisionOf(one, classes)});
    }
    for (const fusion::CrossMatch& match : scene.views.matches) {
      const Sighted& head = scene.views.head[static_cast<std::size_t>(match.object)];
      const Sighted& hand = scene.views.hand[static_cast<std::size_t>(match.box)];
      if (head.thing < 0 || head.thing != hand.thing) continue;
      pairs.push_back({{label(head), DecisionOf(head, classes)}, DecisionOf(hand, classes)});
    }
  }
  Conflicts conflicts;
  Rng rng(1);
  while (!pairs.empty() && std::ssize(conflicts.wrong) < kDraws) {
    const auto& [head, hand] = pairs[static_cast<std::size_t>(rng.Index(std::ssize(pairs)))];
    const View& other = hands[static_cast<std::size_t>(rng.Index(std::ssize(hands)))];
    if (other.label == head.label) continue;
    conflicts.right.push_back(disagreement(head.decision.masses, hand.masses));
    conflicts.wrong.push_back(disagreement(head.decision.masses, other.decision.masses));
  }
  return conflicts;
}

class Summary {
 public:
  Summary(const std::vector<Json>& trials, const Classes& classes, std::string report)
      : classes_(classes), report_(std::move(report)) {
    for (const char* condition : kConditions) {
      auto& scenes = scenes_.emplace_back();
      for (const Json& trial : trials) scenes.push_back(ReadScene(trial, condition, classes));
    }
  }

  std::vector<Row> Rows() {
    for (std::size_t i = 0; i < kConditions.size(); ++i) AddCondition(i);
    AddMatches();
    AddConflicts("m(empty)", MassOfConflict);
    AddConflicts("m(empty) of what both views commit to", fusion::CommittedConflict);
    return rows_;
  }

 private:
  void AddCondition(std::size_t condition) {
    const std::vector<Scene>& scenes = scenes_[condition];
    const auto count = static_cast<int>(scenes.size());
    std::vector<std::vector<ConfusionMatrix>> all;  // by decider and scene
    const std::vector<NamedDecider> deciders = Deciders(classes_);
    using Figure = double (ConfusionMatrix::*)() const;
    constexpr std::array<std::pair<const char*, Figure>, 4> kFigures{
        {{"accuracy", &ConfusionMatrix::Accuracy},
         {"macro precision", &ConfusionMatrix::Precision},
         {"macro recall", &ConfusionMatrix::Recall},
         {"F1", &ConfusionMatrix::F1}}};
    for (const NamedDecider& decider : deciders) {
      auto& matrices = all.emplace_back();
      for (const Scene& scene : scenes) {
        matrices.push_back(Judge(scene, decider.decide(scene), classes_));
      }
      const bool fused = decider.name.starts_with("fused");
      for (std::size_t f = 0; f < kFigures.size(); ++f) {
        const Figure figure = kFigures[f].second;
        const PaperFigures& paper = kPaper[condition][f];
        const auto of = [figure](const std::vector<ConfusionMatrix>& by_scene) {
          return [&by_scene, figure](const std::vector<int>& drawn) {
            return (Sum(by_scene, drawn).*figure)();
          };
        };
        rows_.push_back(
            {fmt::format("{}: {}, {}", kConditions[condition], kFigures[f].first, decider.name),
             Bootstrapped(count, of(matrices)),
             decider.name == "hand alone" ? std::nullopt
             : fused                      ? std::optional(paper.fused)
                                          : std::optional(paper.head),
             fused ? std::optional(Bootstrapped(count, of(all.front())).value) : std::nullopt});
      }
      rows_.push_back(
          {fmt::format("{}: false detections a scene, {}", kConditions[condition], decider.name),
           Bootstrapped(count, [&](const std::vector<int>& drawn) {
             return Sum(matrices, drawn).FalseDetections() / static_cast<double>(drawn.size());
           })});
      WriteMatrix(condition, decider.name, matrices);
    }
    for (std::size_t alone = 0; alone < 2; ++alone) {
      rows_.push_back({fmt::format("{}: accuracy, fused by belief masses less {}",
                                   kConditions[condition], deciders[alone].name),
                       Bootstrapped(count, [&](const std::vector<int>& drawn) {
                         return Sum(all[4], drawn).Accuracy() - Sum(all[alone], drawn).Accuracy();
                       })});
    }
    AddEconomy(condition);
  }

  /// How many of the matched need a second look by the gate.
  void AddEconomy(std::size_t condition) {
    std::vector<double> second;
    std::vector<double> matched;
    for (const Scene& scene : scenes_[condition]) {
      matched.push_back(static_cast<double>(scene.views.matches.size()));
      second.push_back(0.0);
      for (const fusion::CrossMatch& match : scene.views.matches) {
        const ViewDecision first =
            DecisionOf(scene.views.head[static_cast<std::size_t>(match.object)], classes_);
        const auto p = FuseDecisions(FusionRule::kAveraging, {first}).probabilities;
        if (fusion::ConfidenceRatio(p) < kGate) second.back() += 1.0;
      }
    }
    rows_.push_back(
        {fmt::format("{}: matched things classified twice, gate {}", kConditions[condition], kGate),
         BootstrappedRatio(second, matched), std::nullopt, 1.0});
  }

  void AddMatches() {
    for (std::size_t condition = 0; condition < kConditions.size(); ++condition) {
      int matches = 0;
      int wrong = 0;
      for (const Scene& scene : scenes_[condition]) {
        for (const fusion::CrossMatch& match : scene.views.matches) {
          const int head = scene.views.head[static_cast<std::size_t>(match.object)].thing;
          const int hand = scene.views.hand[static_cast<std::size_t>(match.box)].thing;
          if (head < 0 || hand < 0) continue;
          ++matches;
          if (head != hand) ++wrong;
        }
      }
      rows_.push_back({fmt::format("{}: wrong matches across the cameras", kConditions[condition]),
                       Proportion(wrong, matches)});
    }
  }

  void AddConflicts(const std::string& by, Disagreement disagreement) {
    const Conflicts conflicts = DrawConflicts(scenes_.front(), classes_, disagreement);
    if (conflicts.right.empty()) return;
    std::vector<double> right = conflicts.right;
    std::sort(right.begin(), right.end());
    const double threshold = right[right.size() * 95 / 100];
    const auto flagged = std::count_if(conflicts.wrong.begin(), conflicts.wrong.end(),
                                       [&](double conflict) { return conflict > threshold; });
    rows_.push_back(
        {fmt::format("injected wrong matches flagged by {} at 5 % false alarms", by),
         Proportion(static_cast<int>(flagged), static_cast<int>(conflicts.wrong.size()))});
    rows_.push_back(
        {fmt::format("injected wrong matches by {}: area under the ROC curve", by),
         Bootstrapped(static_cast<int>(right.size()), [&](const std::vector<int>& drawn) {
           std::vector<double> wrong;
           for (const int i : drawn) {
             wrong.push_back(conflicts.wrong[static_cast<std::size_t>(i)]);
           }
           return AreaUnderCurve(right, wrong);
         })});
  }

  /// The chance that a wrong match has more conflict than a right one. @pre `right` is sorted.
  static double AreaUnderCurve(const std::vector<double>& right, const std::vector<double>& wrong) {
    double wins = 0.0;
    for (const double w : wrong) {
      const auto [first, last] = std::equal_range(right.begin(), right.end(), w);
      wins += static_cast<double>(first - right.begin()) + 0.5 * static_cast<double>(last - first);
    }
    return wins / static_cast<double>(right.size() * wrong.size());
  }

  void WriteMatrix(std::size_t condition, const std::string& decider,
                   const std::vector<ConfusionMatrix>& matrices) const {
    if (report_.empty() || matrices.empty()) return;
    ConfusionMatrix sum(static_cast<int>(classes_.things.size()));
    for (const ConfusionMatrix& matrix : matrices) sum += matrix;
    std::string name = fmt::format("confusion_{}_{}", kConditions[condition], decider);
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == ' ' || c == ','; }, '_');
    WritePicture(sum, classes_.things, fmt::format("{}: {}", kConditions[condition], decider),
                 std::filesystem::path(report_) / (name + ".png"));
  }

  const Classes& classes_;
  std::string report_;
  std::vector<std::vector<Scene>> scenes_;  // by condition
  std::vector<Row> rows_;
};

std::vector<sim::SceneObject> DrawThings(const ExperimentOptions& options) {
  std::vector<sim::SceneObject> known = LoadRepertoire(options.models, "").known;
  std::erase_if(known, [](const sim::SceneObject& thing) { return kTwins.contains(thing.name); });
  if (std::ssize(known) < kThings) {
    Throw<ConfigError>("--models {}: holds {} models; ds-fusion needs {}", options.models,
                       known.size(), kThings);
  }
  Rng rng(ForkSeed(options.seed, "things"));
  return DrawObjects(std::move(known), kThings, &rng);
}

std::unique_ptr<perception::Classifier> MakeClassifier(const std::vector<sim::SceneObject>& things,
                                                       const ExperimentOptions& options) {
  if (!options.classifier.empty()) return perception::LoadClassifier(options.classifier);
  spdlog::info("training a support vector machine on rendered pictures");
  const perception::TrainingSet set = RenderTrainingSet(things, ForkSeed(options.seed, "training"));
  auto classifier = perception::FeatureClassifier::Train(
      perception::FeatureClassifierKind::kSvm, set, {3, 1, options.seed},
      [](const std::string& line) { spdlog::info("{}", line); });
  if (!options.report.empty()) {
    classifier->Save(std::filesystem::path(options.report) / "classifier.yml");
  }
  return classifier;
}

}  // namespace

void RunDsFusionExperiment(const ExperimentOptions& options) {
  const std::vector<sim::SceneObject> things = DrawThings(options);
  if (!options.report.empty()) std::filesystem::create_directories(options.report);
  const auto classifier = MakeClassifier(things, options);
  Classes classes{classifier->classes(), {}};
  for (const sim::SceneObject& thing : things) classes.things.push_back(thing.name);
  std::sort(classes.things.begin(), classes.things.end());
  std::vector<std::string> needed = classes.things;
  needed.emplace_back(perception::kBackgroundClass);
  perception::CheckClasses(*classifier, needed, options.classifier);
  RunTrials(
      "ds-fusion", options,
      [&](int t) {
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("trial {}", t));
        const sim::Scene scene = DrawTestTable(things, seed);
        Json trial;
        for (const sim::SceneObject& thing : scene.objects) {
          trial["things"].push_back(thing.name);
        }
        trial[kConditions[0]] = ToJson(LookTwice(scene, *classifier, seed));
        trial[kConditions[1]] = ToJson(LookTwice(WithOccluders(scene, seed), *classifier, seed));
        return trial;
      },
      [&](const std::vector<Json>& trials) {
        return Summary(trials, classes, options.report).Rows();
      });
}

}  // namespace secondlook::apps
