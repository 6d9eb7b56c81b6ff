#include "apps/experiments/nbv_summary.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "apps/experiments/nbv_distortion.h"
#include "apps/experiments/plot.h"
#include "lib/common/rng.h"
#include "lib/fusion/decision_fusion.h"
#include "lib/planning/tile_vote.h"

namespace secondlook::apps {
namespace {

using fusion::FusionRule;
using planning::Criterion;
using planning::ScoredTile;

constexpr int kBins = 15;  // of the calibration error
constexpr std::array kRules{std::pair{FusionRule::kNaiveBayes, "naive Bayes"},
                            std::pair{FusionRule::kAveraging, "averaging"},
                            std::pair{FusionRule::kTransferableBelief, "belief masses"}};
constexpr std::array kCriterionNames{
    "variance",      "third moment", "parallelism", "light",           "metric parallelism",
    "dissimilarity", "uniformity",   "entropy",     "information gain"};
static_assert(kCriterionNames.size() == planning::kCriteria);

/// What is decided of an object.
struct Decision {
  int said{};                         ///< Index of the class.
  double confidence{};                ///< Its probability.
  double of_truth{};                  ///< The true class's probability.
  double ratio{};                     ///< The largest probability over the second.
  std::vector<double> probabilities;  ///< By class; empty in total conflict.
};

struct Decided {
  Decision front;
  std::array<Decision, kSideCount> with;  ///< By the side that was looked from, too.
};

/// How much each side is looked from; they sum to 1.
using Choice = std::array<double, kSideCount>;
using Chooser = std::function<Choice(int set, int which)>;

constexpr Choice kAnySide{0.2, 0.2, 0.2, 0.2, 0.2};

Choice Only(std::size_t side) {
  Choice choice{};
  choice[side] = 1.0;
  return choice;
}

/// The decisions of a case for one way to choose, each with the share in which it comes about.
struct Shared {
  double share;
  const Decision* decision;
};

class Analysis {
 public:
  Analysis(const std::vector<NbvSet>& sets, const NbvClassifier& classifier)
      : sets_(sets), classifier_(classifier) {
    for (const auto& [rule, name] : kRules) {
      auto& decided = decided_[rule];
      for (const NbvSet& set : sets) {
        auto& cases = decided.emplace_back();
        for (const NbvCase& one : set.cases) cases.push_back(Decide(rule, set, one));
      }
    }
  }

  const std::vector<NbvSet>& sets() const { return sets_; }
  int set_count() const { return static_cast<int>(sets_.size()); }
  const Decided& Of(FusionRule rule, int set, int which) const {
    return decided_.at(rule)[set][which];
  }

  /// What comes of looking from the sides that `chooser` says, where the first view's ratio is
  /// below `gate`.
  std::vector<Shared> Result(FusionRule rule, const Chooser& chooser, int set, int which,
                             double gate) const {
    const Decided& decided = Of(rule, set, which);
    if (!(decided.front.ratio < gate)) return {{1.0, &decided.front}};
    std::vector<Shared> shared;
    const Choice choice = chooser(set, which);
    for (std::size_t s = 0; s < kSideCount; ++s) {
      if (choice[s] > 0.0) shared.push_back({choice[s], &decided.with[s]});
    }
    return shared;
  }

  /// By set: how many of its cases are right; `wanted`: of which distortion, -1 all.
  std::vector<double> Right(FusionRule rule, const Chooser& chooser, double gate = kAlways,
                            int wanted = -1) const {
    std::vector<double> right(sets_.size(), 0.0);
    for (int i = 0; i < set_count(); ++i) {
      for (int k = 0; k < std::ssize(sets_[i].cases); ++k) {
        if (wanted >= 0 && sets_[i].cases[k].distortion != wanted) continue;
        for (const Shared& s : Result(rule, chooser, i, k, gate)) {
          if (s.decision->said == sets_[i].truth) right[i] += s.share;
        }
      }
    }
    return right;
  }

  /// By set: the number of cases.
  std::vector<double> Count(int wanted = -1) const {
    std::vector<double> count;
    for (const NbvSet& set : sets_) {
      count.push_back(static_cast<double>(std::count_if(
          set.cases.begin(), set.cases.end(),
          [&](const NbvCase& one) { return wanted < 0 || one.distortion == wanted; })));
    }
    return count;
  }

  /// m(empty) of the first view of a case and the view of a side, of two sets or of one.
  double Conflict(int front_set, int which, int side_set, std::size_t side) const {
    constexpr FusionRule kRule = FusionRule::kNaiveBayes;  // nothing discounted
    return FuseDecisions(kRule, {View(sets_[front_set].cases[which].front, kRule),
                                 View(sets_[side_set].sides[side], kRule)})
        .masses.conflict;
  }

  static constexpr double kAlways = std::numeric_limits<double>::infinity();
  static constexpr double kNever = 0.0;

 private:
  fusion::ViewDecision View(const std::vector<double>& probabilities, FusionRule rule) const {
    fusion::ViewDecision view;
    view.masses.omega = 0.0;
    for (std::size_t c = 0; c < probabilities.size(); ++c) {
      if (classifier_.classes[c] == "unknown") {
        view.masses.omega = probabilities[c];
      } else {
        view.masses.singletons[classifier_.classes[c]] = probabilities[c];
      }
    }
    if (rule == FusionRule::kTransferableBelief) view.reliability = classifier_.reliability;
    return view;
  }

  Decision DecisionOf(const std::map<std::string, double>& p, int truth) const {
    const std::string said = fusion::MostProbable(p);
    if (said.empty()) return {-1, 0.0, 0.0, 0.0, {}};  // total conflict
    const auto& classes = classifier_.classes;
    std::vector<double> by_class;
    for (const std::string& c : classes) by_class.push_back(p.contains(c) ? p.at(c) : 0.0);
    return {static_cast<int>(std::find(classes.begin(), classes.end(), said) - classes.begin()),
            p.at(said), p.at(classes[truth]), fusion::ConfidenceRatio(p), by_class};
  }

  Decided Decide(FusionRule rule, const NbvSet& set, const NbvCase& one) const {
    const fusion::ViewDecision front = View(one.front, rule);
    Decided decided;
    decided.front = DecisionOf(FuseDecisions(rule, {front}).probabilities, set.truth);
    for (std::size_t s = 0; s < kSideCount; ++s) {
      const fusion::ViewDecision side = View(set.sides[s], rule);
      decided.with[s] = DecisionOf(FuseDecisions(rule, {front, side}).probabilities, set.truth);
    }
    return decided;
  }

  const std::vector<NbvSet>& sets_;
  const NbvClassifier& classifier_;
  std::map<FusionRule, std::vector<std::vector<Decided>>> decided_;
};

/// The side that a vote ranks first, or `rank` places after it; any, when there are not so many
/// that are not refused.
Choice Vote(const std::array<ScoredTile, kSideCount>& sides,
            const std::vector<planning::Voter>& voters, planning::VoteRule rule, bool refuse,
            std::size_t rank = 0) {
  std::vector<ScoredTile> tiles(sides.begin(), sides.end());
  if (!refuse) {
    for (ScoredTile& tile : tiles) tile.refusal.clear();
  }
  const planning::TileRanking ranking = RankTiles(tiles, voters, rule);
  if (ranking.tiles.size() <= rank) return kAnySide;
  const auto* const side = std::find(kSides.begin(), kSides.end(), ranking.tiles[rank].tile);
  return Only(static_cast<std::size_t>(side - kSides.begin()));
}

/// What a learned chooser goes by: which side it is, and how it scores among the five.
constexpr int kFeatures = static_cast<int>(kSideCount) + planning::kCriteria + 1;

Eigen::MatrixXd Features(const NbvCase& one) {
  Eigen::MatrixXd features = Eigen::MatrixXd::Zero(kSideCount, kFeatures);
  features.leftCols<kSideCount>().setIdentity();
  for (int f = 0; f < planning::kCriteria + 1; ++f) {
    Eigen::VectorXd scores(kSideCount);
    for (std::size_t s = 0; s < kSideCount; ++s) {
      scores[s] = f < planning::kCriteria ? one.sides[s].scores[f] : one.sides[s].foreground;
    }
    if (!scores.allFinite()) continue;
    scores.array() -= scores.mean();
    const double deviation = std::sqrt(scores.squaredNorm() / kSideCount);
    if (deviation > 1e-9) features.col(kSideCount + f) = scores / deviation;
  }
  return features;
}

/// Ridge regression from features to how much more probable than from the other sides the true
/// class becomes on average, learnt from the sets for which `learn` holds.
Eigen::VectorXd LearnGain(const Analysis& analysis, const std::function<bool(int)>& learn) {
  constexpr double kRidge = 100.0;  // cases
  Eigen::MatrixXd products = kRidge * Eigen::MatrixXd::Identity(kFeatures, kFeatures);
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(kFeatures);
  for (int i = 0; i < analysis.set_count(); ++i) {
    if (!learn(i)) continue;
    for (int k = 0; k < std::ssize(analysis.sets()[i].cases); ++k) {
      const Decided& decided = analysis.Of(FusionRule::kNaiveBayes, i, k);
      Eigen::VectorXd gain(kSideCount);
      for (std::size_t s = 0; s < kSideCount; ++s) {
        gain[s] = decided.with[s].of_truth;
      }
      gain.array() -= gain.mean();
      const Eigen::MatrixXd features = Features(analysis.sets()[i].cases[k]);
      products += features.transpose() * features;
      sums += features.transpose() * gain;
    }
  }
  return products.ldlt().solve(sums);
}

/// By block: what was learnt from all others.
std::map<int, Eigen::VectorXd> LearnGains(const Analysis& analysis) {
  std::map<int, Eigen::VectorXd> weights;
  for (const NbvSet& set : analysis.sets()) weights.try_emplace(set.block);
  if (weights.size() < 2) return {};
  for (auto& [block, w] : weights) {
    const int tested = block;
    w = LearnGain(analysis, [&](int i) { return analysis.sets()[i].block != tested; });
  }
  return weights;
}

struct NamedChooser {
  std::string name;
  Chooser choose;
};

std::vector<NamedChooser> Choosers(const Analysis& analysis) {
  const auto sides = [&](int set, int which) -> const auto& {
    return analysis.sets()[set].cases[which].sides;
  };
  std::vector<NamedChooser> choosers;
  choosers.push_back({"random side", [](int, int) { return kAnySide; }});
  for (std::size_t s = 0; s < kSideCount; ++s) {
    choosers.push_back(
        {fmt::format("always {}", TileName(kSides[s])), [s](int, int) { return Only(s); }});
  }
  for (int c = 0; c < planning::kCriteria; ++c) {
    choosers.push_back({kCriterionNames[c], [=](int set, int which) {
                          return Vote(sides(set, which), {{static_cast<Criterion>(c)}},
                                      planning::VoteRule::kPlurality, false);
                        }});
  }
  choosers.push_back({"paper's vote", [=](int set, int which) {
                        return Vote(sides(set, which), planning::PaperVoters(),
                                    planning::VoteRule::kPlurality, false);
                      }});
  choosers.push_back(
      {"our vote", [=](int set, int which) {
         return Vote(sides(set, which),
                     {{Criterion::kVariance}, {Criterion::kMetricParallelism}, {Criterion::kLight}},
                     planning::VoteRule::kBorda, true);
       }});
  if (auto weights = LearnGains(analysis); !weights.empty()) {
    choosers.push_back({"learned", [&analysis, weights](int set, int which) {
                          const NbvSet& all = analysis.sets()[set];
                          Eigen::Index best = 0;
                          (Features(all.cases[which]) * weights.at(all.block)).maxCoeff(&best);
                          return Only(static_cast<std::size_t>(best));
                        }});
  }
  choosers.push_back({"oracle", [&analysis](int set, int which) {
                        const auto& with = analysis.Of(FusionRule::kNaiveBayes, set, which).with;
                        const auto* const best = std::max_element(
                            with.begin(), with.end(), [](const Decision& a, const Decision& b) {
                              return a.of_truth < b.of_truth;
                            });
                        return Only(static_cast<std::size_t>(best - with.begin()));
                      }});
  return choosers;
}

std::vector<double> Difference(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

/// What goes into precision, recall and calibration, of one set.
struct Tally {
  std::vector<double> said;  ///< Weight by class said; the truth is the set's.
  std::array<double, kBins> count{};
  std::array<double, kBins> confidence{};
  std::array<double, kBins> right{};
};

std::vector<Tally> TallyAll(const Analysis& analysis, std::size_t classes, const Chooser& chooser,
                            double gate) {
  std::vector<Tally> tallies;
  for (int i = 0; i < analysis.set_count(); ++i) {
    Tally& tally = tallies.emplace_back();
    tally.said.assign(classes, 0.0);
    for (int k = 0; k < std::ssize(analysis.sets()[i].cases); ++k) {
      for (const Shared& s : analysis.Result(FusionRule::kNaiveBayes, chooser, i, k, gate)) {
        if (s.decision->said < 0) continue;
        tally.said[s.decision->said] += s.share;
        const int bin = std::min(static_cast<int>(s.decision->confidence * kBins), kBins - 1);
        tally.count[bin] += s.share;
        tally.confidence[bin] += s.share * s.decision->confidence;
        if (s.decision->said == analysis.sets()[i].truth) tally.right[bin] += s.share;
      }
    }
  }
  return tallies;
}

struct Macro {
  double precision{};
  double recall{};
  double f1{};  ///< Mean of the classes' own.
};

/// Over the classes that occur; one that is never said has precision 0.
Macro MacroOf(const std::vector<Tally>& tallies, const std::vector<NbvSet>& sets,
              const std::vector<int>& drawn) {
  const std::size_t classes = tallies.front().said.size();
  std::vector<double> hits(classes, 0.0);
  std::vector<double> said(classes, 0.0);
  std::vector<double> true_ones(classes, 0.0);
  for (const int i : drawn) {
    for (std::size_t c = 0; c < classes; ++c) {
      said[c] += tallies[i].said[c];
      true_ones[sets[i].truth] += tallies[i].said[c];
    }
    hits[sets[i].truth] += tallies[i].said[sets[i].truth];
  }
  Macro macro;
  double occurring = 0.0;
  for (std::size_t c = 0; c < classes; ++c) {
    if (true_ones[c] == 0.0) continue;
    occurring += 1.0;
    macro.precision += said[c] > 0.0 ? hits[c] / said[c] : 0.0;
    macro.recall += hits[c] / true_ones[c];
    macro.f1 += 2.0 * hits[c] / (said[c] + true_ones[c]);
  }
  return {macro.precision / occurring, macro.recall / occurring, macro.f1 / occurring};
}

/// The probabilities of true and of other classes, by their log odds: of a set.
struct RocTally {
  static constexpr int kBins = 400;
  std::vector<double> positive = std::vector<double>(kBins, 0.0);
  std::vector<double> negative = std::vector<double>(kBins, 0.0);

  void Add(double probability, bool true_class, double weight) {
    constexpr double kMaxLogOdds = 20.0;
    const double p = std::clamp(probability, 1e-12, 1.0 - 1e-12);
    const double share = 0.5 + 0.5 * std::log(p / (1.0 - p)) / kMaxLogOdds;
    const int bin = std::clamp(static_cast<int>(share * kBins), 0, kBins - 1);
    (true_class ? positive : negative)[bin] += weight;
  }
};

/// Every class of every decision is one that is told or not (micro-averaging).
std::vector<RocTally> RocTallies(const Analysis& analysis, const Chooser& chooser, double gate) {
  std::vector<RocTally> tallies(analysis.sets().size());
  for (int i = 0; i < analysis.set_count(); ++i) {
    for (int k = 0; k < std::ssize(analysis.sets()[i].cases); ++k) {
      for (const Shared& s : analysis.Result(FusionRule::kNaiveBayes, chooser, i, k, gate)) {
        const std::vector<double>& p = s.decision->probabilities;
        for (int c = 0; c < std::ssize(p); ++c) {
          tallies[i].Add(p[c], c == analysis.sets()[i].truth, s.share);
        }
      }
    }
  }
  return tallies;
}

/// (false positive rate, true positive rate), from (0, 0) to (1, 1).
std::vector<Eigen::Vector2d> RocCurve(const std::vector<RocTally>& tallies,
                                      const std::vector<int>& drawn) {
  RocTally sum;
  for (const int i : drawn) {
    for (int bin = 0; bin < RocTally::kBins; ++bin) {
      sum.positive[bin] += tallies[i].positive[bin];
      sum.negative[bin] += tallies[i].negative[bin];
    }
  }
  Eigen::Vector2d all = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> curve{all};
  for (int bin = RocTally::kBins - 1; bin >= 0; --bin) {
    all += Eigen::Vector2d(sum.negative[bin], sum.positive[bin]);
    curve.push_back(all);
  }
  for (Eigen::Vector2d& point : curve) point.array() /= all.array().max(1e-300);
  return curve;
}

double AreaUnder(const std::vector<Eigen::Vector2d>& curve) {
  double area = 0.0;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    area += (curve[i].x() - curve[i - 1].x()) * 0.5 * (curve[i].y() + curve[i - 1].y());
  }
  return area;
}

double CalibrationError(const std::vector<Tally>& tallies, const std::vector<int>& drawn) {
  double error = 0.0;
  double all = 0.0;
  for (int bin = 0; bin < kBins; ++bin) {
    double difference = 0.0;
    for (const int i : drawn) {
      difference += tallies[i].confidence[bin] - tallies[i].right[bin];
      all += tallies[i].count[bin];
    }
    error += std::abs(difference);
  }
  return all > 0.0 ? error / all : 0.0;
}

/// m(empty) of a view and one of the same object, and of a view and one of another class: as many
/// draws as there are.
struct Conflicts {
  std::vector<double> right;
  std::vector<double> wrong;
};

Conflicts DrawConflicts(const Analysis& analysis) {
  constexpr int kDraws = 1000;
  Conflicts conflicts;
  Rng rng(1);
  const std::vector<NbvSet>& sets = analysis.sets();
  for (int draw = 0; draw < kDraws; ++draw) {
    const int i = rng.Index(analysis.set_count());
    const int other = rng.Index(analysis.set_count());
    const int which = rng.Index(static_cast<int>(sets[i].cases.size()));
    const auto side = static_cast<std::size_t>(rng.Index(kSideCount));
    if (sets[other].truth == sets[i].truth) continue;
    conflicts.right.push_back(analysis.Conflict(i, which, i, side));
    conflicts.wrong.push_back(analysis.Conflict(i, which, other, side));
  }
  return conflicts;
}

/// The chance that a wrong match has more conflict than a right one.
double AreaUnderCurve(const Conflicts& conflicts) {
  double wins = 0.0;
  for (const double wrong : conflicts.wrong) {
    for (const double right : conflicts.right) {
      wins += wrong > right ? 1.0 : (wrong == right ? 0.5 : 0.0);
    }
  }
  return wins / static_cast<double>(conflicts.wrong.size() * conflicts.right.size());
}

class Rows {
 public:
  Rows(const Analysis& analysis, const NbvClassifier& classifier, std::string report)
      : analysis_(analysis),
        classifier_(classifier),
        report_(std::move(report)),
        choosers_(Choosers(analysis)) {}

  std::vector<Row> All() {
    Accuracies();
    Gaps();
    Measures();
    Rocs();
    Gates();
    SecondLooks();
    WrongMatches();
    Distortions();
    Blocks();
    Ranks();
    return rows_;
  }

 private:
  static constexpr FusionRule kMain = FusionRule::kNaiveBayes;

  const Chooser& Named(const std::string& name) const {
    return std::find_if(choosers_.begin(), choosers_.end(),
                        [&](const NamedChooser& c) { return c.name == name; })
        ->choose;
  }
  bool Has(const std::string& name) const {
    return std::any_of(choosers_.begin(), choosers_.end(),
                       [&](const NamedChooser& c) { return c.name == name; });
  }
  std::string Ours() const { return Has("learned") ? "learned" : "our vote"; }

  void Accuracies() {
    const std::vector<double> count = analysis_.Count();
    for (const auto& [rule, name] : kRules) {
      const Estimate single =
          BootstrappedRatio(analysis_.Right(rule, Named("random side"), Analysis::kNever), count);
      rows_.push_back({fmt::format("accuracy, {}: single view", name), single});
      for (const NamedChooser& chooser : choosers_) {
        rows_.push_back({fmt::format("accuracy, {}: {}", name, chooser.name),
                         BootstrappedRatio(analysis_.Right(rule, chooser.choose), count),
                         {},
                         single.value});
      }
    }
  }

  void Gaps() {
    const std::vector<double> count = analysis_.Count();
    const std::vector<double> random = analysis_.Right(kMain, Named("random side"));
    const std::vector<double> gap = Difference(analysis_.Right(kMain, Named("oracle")), random);
    for (const NamedChooser& chooser : choosers_) {
      if (chooser.name == "random side" || chooser.name == "oracle") continue;
      rows_.push_back(
          {fmt::format("share of the gap from random to oracle: {}", chooser.name),
           BootstrappedRatio(Difference(analysis_.Right(kMain, chooser.choose), random), gap)});
    }
    const std::vector<double> ours = analysis_.Right(kMain, Named(Ours()));
    rows_.push_back({fmt::format("accuracy, {} less random", Ours()),
                     BootstrappedRatio(Difference(ours, random), count), 0.057});
    for (const planning::Tile side : kSides) {
      const std::string fixed = fmt::format("always {}", TileName(side));
      rows_.push_back(
          {fmt::format("accuracy, {} less {}", Ours(), fixed),
           BootstrappedRatio(Difference(ours, analysis_.Right(kMain, Named(fixed))), count)});
    }
  }

  void Measures() {
    const std::vector<std::pair<std::string, std::vector<Tally>>> all{
        {"single view",
         TallyAll(analysis_, classifier_.classes.size(), Named("random side"), Analysis::kNever)},
        {"random side",
         TallyAll(analysis_, classifier_.classes.size(), Named("random side"), Analysis::kAlways)},
        {Ours(),
         TallyAll(analysis_, classifier_.classes.size(), Named(Ours()), Analysis::kAlways)}};
    const auto figure = [&](const std::string& metric,
                            const std::function<double(const std::vector<int>&)>& of) {
      rows_.push_back({metric, Bootstrapped(analysis_.set_count(), of)});
    };
    for (const auto& named : all) {
      const std::vector<Tally>& tallies = named.second;
      const auto macro = [&](const std::vector<int>& drawn) {
        return MacroOf(tallies, analysis_.sets(), drawn);
      };
      figure("macro precision: " + named.first,
             [&](const std::vector<int>& drawn) { return macro(drawn).precision; });
      figure("macro recall: " + named.first,
             [&](const std::vector<int>& drawn) { return macro(drawn).recall; });
      figure("macro F1: " + named.first,
             [&](const std::vector<int>& drawn) { return macro(drawn).f1; });
      figure("expected calibration error: " + named.first,
             [&](const std::vector<int>& drawn) { return CalibrationError(tallies, drawn); });
    }
  }

  void Rocs() {
    std::vector<Curve> curves;
    std::vector<int> all_sets(analysis_.sets().size());
    std::iota(all_sets.begin(), all_sets.end(), 0);
    const auto add = [&](const std::string& name, const std::string& chooser, double gate) {
      const std::vector<RocTally> tallies = RocTallies(analysis_, Named(chooser), gate);
      rows_.push_back({"area under the micro-averaged ROC curve: " + name,
                       Bootstrapped(analysis_.set_count(), [&](const std::vector<int>& drawn) {
                         return AreaUnder(RocCurve(tallies, drawn));
                       })});
      curves.push_back({name, RocCurve(tallies, all_sets)});
    };
    add("single view", "random side", Analysis::kNever);
    add("random side", "random side", Analysis::kAlways);
    add("paper's vote", "paper's vote", Analysis::kAlways);
    add(Ours(), Ours(), Analysis::kAlways);
    if (report_.empty()) return;
    WritePlot({"ROC, micro-averaged, naive Bayes",
               "false positive rate",
               "true positive rate",
               {0.0, 0.5},
               {0.5, 1.0}},
              curves, std::filesystem::path(report_) / "roc.png");
  }

  /// The gate that sends the least sure trials, such a share of all, for a second look.
  double GateFor(double share) const {
    std::vector<double> ratios;
    for (int i = 0; i < analysis_.set_count(); ++i) {
      for (int k = 0; k < std::ssize(analysis_.sets()[i].cases); ++k) {
        ratios.push_back(analysis_.Of(kMain, i, k).front.ratio);
      }
    }
    std::sort(ratios.begin(), ratios.end());
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(ratios.size()));
    return rank < ratios.size() ? ratios[rank] : Analysis::kAlways;
  }

  /// Accuracy against the share of trials with a second look.
  void SecondLooks() {
    constexpr int kSteps = 10;
    const std::vector<double> count = analysis_.Count();
    std::vector<Curve> curves;
    for (const std::string& name :
         {std::string("random side"), std::string("paper's vote"), Ours(), std::string("oracle")}) {
      Curve& curve = curves.emplace_back(Curve{name, {}});
      for (int step = 0; step <= kSteps; ++step) {
        const double share = static_cast<double>(step) / kSteps;
        const double gate = step == 0 ? Analysis::kNever : GateFor(share);
        const Estimate accuracy =
            BootstrappedRatio(analysis_.Right(kMain, Named(name), gate), count);
        curve.points.emplace_back(share, accuracy.value);
        if (step == 4) {
          rows_.push_back(
              {fmt::format("accuracy with a second look in 40 % of the trials: {}", name),
               accuracy});
        }
      }
    }
    if (report_.empty()) return;
    WritePlot({"Accuracy against second looks, naive Bayes",
               "share of trials with a second look",
               "accuracy",
               {0.0, 0.7},
               {1.0, 1.0}},
              curves, std::filesystem::path(report_) / "second_looks.png");
  }

  void Gates() {
    const std::vector<double> count = analysis_.Count();
    for (const double gate : {1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 200.0}) {
      std::vector<double> looks(analysis_.sets().size(), 0.0);
      for (int i = 0; i < analysis_.set_count(); ++i) {
        for (int k = 0; k < std::ssize(analysis_.sets()[i].cases); ++k) {
          if (analysis_.Of(kMain, i, k).front.ratio < gate) looks[i] += 1.0;
        }
      }
      rows_.push_back(
          {fmt::format("gate {}: share of second looks", gate), BootstrappedRatio(looks, count)});
      for (const std::string& name :
           {std::string("random side"), std::string("paper's vote"), Ours()}) {
        rows_.push_back({fmt::format("gate {}: accuracy, {}", gate, name),
                         BootstrappedRatio(analysis_.Right(kMain, Named(name), gate), count)});
      }
    }
    const std::vector<double> single =
        analysis_.Right(FusionRule::kAveraging, Named("random side"), Analysis::kNever);
    const auto gain = [&](const std::string& name, double paper) {
      const std::vector<double> right = analysis_.Right(FusionRule::kAveraging, Named(name), 20.0);
      rows_.push_back({fmt::format("gate 20, averaging: {} less single view", name),
                       BootstrappedRatio(Difference(right, single), count), paper});
    };
    gain("paper's vote", 0.283);  // Hoseini 2021, 5.5, with its SVM
    gain("random side", 0.235);
  }

  void WrongMatches() {
    const Conflicts conflicts = DrawConflicts(analysis_);
    if (conflicts.right.empty()) return;
    std::vector<double> right = conflicts.right;
    std::sort(right.begin(), right.end());
    const double threshold = right[right.size() * 95 / 100];
    const auto flagged = std::count_if(conflicts.wrong.begin(), conflicts.wrong.end(),
                                       [&](double conflict) { return conflict > threshold; });
    rows_.push_back({"wrong matches flagged by m(empty) at 5 % false alarms",
                     Proportion(static_cast<int>(flagged), static_cast<int>(right.size()))});
    const double area = AreaUnderCurve(conflicts);
    rows_.push_back({"wrong matches by m(empty): area under the ROC curve", {area, area, area}});
  }

  void Distortions() {
    for (int d = 0; d < std::ssize(kDistortions); ++d) {
      const std::vector<double> count = analysis_.Count(d);
      const Estimate single = BootstrappedRatio(
          analysis_.Right(kMain, Named("random side"), Analysis::kNever, d), count);
      rows_.push_back(
          {fmt::format("{}: accuracy, {}", kDistortions[d], Ours()),
           BootstrappedRatio(analysis_.Right(kMain, Named(Ours()), Analysis::kAlways, d), count),
           {},
           single.value});
    }
  }

  /// A block of sets has a light and a background of its own.
  void Blocks() {
    const std::vector<double> single =
        analysis_.Right(kMain, Named("random side"), Analysis::kNever);
    const std::vector<double> ours = analysis_.Right(kMain, Named(Ours()));
    const std::vector<double> count = analysis_.Count();
    std::set<int> blocks;
    for (const NbvSet& set : analysis_.sets()) blocks.insert(set.block);
    for (const int block : blocks) {
      const auto of_block = [&](const std::vector<double>& values) {
        std::vector<double> some;
        for (std::size_t i = 0; i < values.size(); ++i) {
          if (analysis_.sets()[i].block == block) some.push_back(values[i]);
        }
        return some;
      };
      rows_.push_back({fmt::format("light and background {}: accuracy, {}", block + 1, Ours()),
                       BootstrappedRatio(of_block(ours), of_block(count)),
                       {},
                       BootstrappedRatio(of_block(single), of_block(count)).value});
    }
  }

  /// Whether a side that the paper's vote ranks higher is the better one.
  void Ranks() {
    const double random =
        BootstrappedRatio(analysis_.Right(kMain, Named("random side")), analysis_.Count()).value;
    for (std::size_t rank = 0; rank < kSideCount; ++rank) {
      const auto ranked = [&](int set, int which) {
        return Vote(analysis_.sets()[set].cases[which].sides, planning::PaperVoters(),
                    planning::VoteRule::kPlurality, false, rank);
      };
      rows_.push_back(
          {fmt::format("accuracy from the side that the paper's vote ranks {}", rank + 1),
           BootstrappedRatio(analysis_.Right(kMain, ranked), analysis_.Count()),
           {},
           random});
    }
  }

  const Analysis& analysis_;
  const NbvClassifier& classifier_;
  std::string report_;  // folder of the plots; "": none
  std::vector<NamedChooser> choosers_;
  std::vector<Row> rows_;
};

}  // namespace

std::vector<Row> SummariseNbv(const std::vector<NbvSet>& sets, const NbvClassifier& classifier,
                              const std::string& report) {
  if (sets.empty()) return {};
  const Analysis analysis(sets, classifier);
  return Rows(analysis, classifier, report).All();
}

}  // namespace secondlook::apps
