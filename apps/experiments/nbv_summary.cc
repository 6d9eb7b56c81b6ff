#include "apps/experiments/nbv_summary.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "apps/experiments/nbv_choosers.h"
#include "apps/experiments/nbv_distortion.h"
#include "apps/experiments/nbv_experience.h"
#include "apps/experiments/nbv_measures.h"
#include "apps/experiments/plot.h"

namespace secondlook::apps {
namespace {

using fusion::FusionRule;
using nbv::AreaUnder;
using nbv::Chooser;
using nbv::Conflicts;
using nbv::Decisions;
using nbv::kRules;
using nbv::NamedChooser;
using nbv::RocTally;
using nbv::Tally;
using nbv::Vote;

std::vector<double> Difference(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

class Rows {
 public:
  Rows(const Decisions& decisions, const NbvClassifier& classifier, std::string report)
      : decisions_(decisions),
        classifier_(classifier),
        report_(std::move(report)),
        choosers_(Choosers(decisions)) {}

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
    const std::vector<double> count = decisions_.Count();
    for (const auto& [rule, name] : kRules) {
      const Estimate single =
          BootstrappedRatio(decisions_.Right(rule, Named("random side"), Decisions::kNever), count);
      rows_.push_back({fmt::format("accuracy, {}: single view", name), single});
      for (const NamedChooser& chooser : choosers_) {
        rows_.push_back({fmt::format("accuracy, {}: {}", name, chooser.name),
                         BootstrappedRatio(decisions_.Right(rule, chooser.choose), count),
                         {},
                         single.value});
      }
    }
  }

  void Gaps() {
    const std::vector<double> count = decisions_.Count();
    const std::vector<double> random = decisions_.Right(kMain, Named("random side"));
    const std::vector<double> gap = Difference(decisions_.Right(kMain, Named("oracle")), random);
    for (const NamedChooser& chooser : choosers_) {
      if (chooser.name == "random side" || chooser.name == "oracle") continue;
      rows_.push_back(
          {fmt::format("share of the gap from random to oracle: {}", chooser.name),
           BootstrappedRatio(Difference(decisions_.Right(kMain, chooser.choose), random), gap)});
    }
    const std::vector<double> ours = decisions_.Right(kMain, Named(Ours()));
    rows_.push_back({fmt::format("accuracy, {} less random", Ours()),
                     BootstrappedRatio(Difference(ours, random), count), 0.057});
    for (const planning::Tile side : kSides) {
      const std::string fixed = fmt::format("always {}", TileName(side));
      rows_.push_back(
          {fmt::format("accuracy, {} less {}", Ours(), fixed),
           BootstrappedRatio(Difference(ours, decisions_.Right(kMain, Named(fixed))), count)});
    }
  }

  void Measures() {
    const std::vector<std::pair<std::string, std::vector<Tally>>> all{
        {"single view",
         TallyAll(decisions_, classifier_.classes.size(), Named("random side"), Decisions::kNever)},
        {"random side", TallyAll(decisions_, classifier_.classes.size(), Named("random side"),
                                 Decisions::kAlways)},
        {Ours(),
         TallyAll(decisions_, classifier_.classes.size(), Named(Ours()), Decisions::kAlways)}};
    const auto figure = [&](const std::string& metric,
                            const std::function<double(const std::vector<int>&)>& of) {
      rows_.push_back({metric, Bootstrapped(decisions_.set_count(), of)});
    };
    for (const auto& named : all) {
      const std::vector<Tally>& tallies = named.second;
      const auto macro = [&](const std::vector<int>& drawn) {
        return MacroOf(tallies, decisions_.sets(), drawn);
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
    std::vector<int> all_sets(decisions_.sets().size());
    std::iota(all_sets.begin(), all_sets.end(), 0);
    const auto add = [&](const std::string& name, const std::string& chooser, double gate) {
      const std::vector<RocTally> tallies = RocTallies(decisions_, Named(chooser), gate);
      rows_.push_back({"area under the micro-averaged ROC curve: " + name,
                       Bootstrapped(decisions_.set_count(), [&](const std::vector<int>& drawn) {
                         return AreaUnder(RocCurve(tallies, drawn));
                       })});
      curves.push_back({name, RocCurve(tallies, all_sets)});
    };
    add("single view", "random side", Decisions::kNever);
    add("random side", "random side", Decisions::kAlways);
    add("paper's vote", "paper's vote", Decisions::kAlways);
    add(Ours(), Ours(), Decisions::kAlways);
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
    for (int i = 0; i < decisions_.set_count(); ++i) {
      for (int k = 0; k < std::ssize(decisions_.sets()[i].cases); ++k) {
        ratios.push_back(decisions_.Of(kMain, i, k).front.ratio);
      }
    }
    std::sort(ratios.begin(), ratios.end());
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(ratios.size()));
    return rank < ratios.size() ? ratios[rank] : Decisions::kAlways;
  }

  /// Accuracy against the share of trials with a second look.
  void SecondLooks() {
    constexpr int kSteps = 10;
    const std::vector<double> count = decisions_.Count();
    std::vector<Curve> curves;
    for (const std::string& name :
         {std::string("random side"), std::string("paper's vote"), Ours(), std::string("oracle")}) {
      Curve& curve = curves.emplace_back(Curve{name, {}});
      for (int step = 0; step <= kSteps; ++step) {
        const double share = static_cast<double>(step) / kSteps;
        const double gate = step == 0 ? Decisions::kNever : GateFor(share);
        const Estimate accuracy =
            BootstrappedRatio(decisions_.Right(kMain, Named(name), gate), count);
        curve.points.emplace_back(share, accuracy.value);
        if (step == 4) {
          rows_.push_back(
              {fmt::format("accuracy with a second look in 40 % of the trials: {}", name),
               accuracy});
        }
      }
    }
    if (Has("learned")) MostPromising();
    if (report_.empty()) return;
    WritePlot({"Accuracy against second looks, naive Bayes",
               "share of trials with a second look",
               "accuracy",
               {0.0, 0.7},
               {1.0, 1.0}},
              curves, std::filesystem::path(report_) / "second_looks.png");
  }

  /// Second looks where experience expects most of them, rather than where the first view is least
  /// sure.
  void MostPromising() {
    constexpr double kShare = 0.4;
    const nbv::ExperienceOfOthers experience(decisions_);
    std::vector<double> promises;
    const auto each = [&](const std::function<void(int set, int which)>& visit) {
      for (int i = 0; i < decisions_.set_count(); ++i) {
        for (int k = 0; k < std::ssize(decisions_.sets()[i].cases); ++k) visit(i, k);
      }
    };
    each([&](int i, int k) { promises.push_back(experience.Promise(i, k)); });
    std::vector<double> sorted = promises;
    std::sort(sorted.begin(), sorted.end(), std::greater<>());
    const double least = sorted[static_cast<std::size_t>(kShare * std::ssize(sorted))];
    std::vector<double> right(decisions_.sets().size(), 0.0);
    std::size_t next = 0;
    each([&](int i, int k) {
      const double gate = promises[next++] > least ? Decisions::kAlways : Decisions::kNever;
      for (const nbv::Shared& s : decisions_.Result(kMain, Named("learned"), i, k, gate)) {
        if (s.decision->said == decisions_.sets()[i].truth) right[i] += s.share;
      }
    });
    rows_.push_back({"accuracy with a second look in the 40 % that promise most: learned",
                     BootstrappedRatio(right, decisions_.Count())});
  }

  void Gates() {
    const std::vector<double> count = decisions_.Count();
    for (const double gate : {1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 200.0}) {
      std::vector<double> looks(decisions_.sets().size(), 0.0);
      for (int i = 0; i < decisions_.set_count(); ++i) {
        for (int k = 0; k < std::ssize(decisions_.sets()[i].cases); ++k) {
          if (decisions_.Of(kMain, i, k).front.ratio < gate) looks[i] += 1.0;
        }
      }
      rows_.push_back(
          {fmt::format("gate {}: share of second looks", gate), BootstrappedRatio(looks, count)});
      for (const std::string& name :
           {std::string("random side"), std::string("paper's vote"), Ours()}) {
        rows_.push_back({fmt::format("gate {}: accuracy, {}", gate, name),
                         BootstrappedRatio(decisions_.Right(kMain, Named(name), gate), count)});
      }
    }
    const std::vector<double> single =
        decisions_.Right(FusionRule::kAveraging, Named("random side"), Decisions::kNever);
    const auto gain = [&](const std::string& name, double paper) {
      const std::vector<double> right = decisions_.Right(FusionRule::kAveraging, Named(name), 20.0);
      rows_.push_back({fmt::format("gate 20, averaging: {} less single view", name),
                       BootstrappedRatio(Difference(right, single), count), paper});
    };
    gain("paper's vote", 0.283);  // Hoseini 2021, 5.5, with its SVM
    gain("random side", 0.235);
  }

  void WrongMatches() {
    const Conflicts conflicts = DrawConflicts(decisions_);
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
      const std::vector<double> count = decisions_.Count(d);
      const Estimate single = BootstrappedRatio(
          decisions_.Right(kMain, Named("random side"), Decisions::kNever, d), count);
      rows_.push_back(
          {fmt::format("{}: accuracy, {}", kDistortions[d], Ours()),
           BootstrappedRatio(decisions_.Right(kMain, Named(Ours()), Decisions::kAlways, d), count),
           {},
           single.value});
    }
  }

  /// A block of sets has a light and a background of its own.
  void Blocks() {
    const std::vector<double> single =
        decisions_.Right(kMain, Named("random side"), Decisions::kNever);
    const std::vector<double> ours = decisions_.Right(kMain, Named(Ours()));
    const std::vector<double> count = decisions_.Count();
    for (const int block : nbv::Blocks(decisions_)) {
      const auto of_block = [&](const std::vector<double>& values) {
        std::vector<double> some;
        for (std::size_t i = 0; i < values.size(); ++i) {
          if (decisions_.sets()[i].block == block) some.push_back(values[i]);
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
        BootstrappedRatio(decisions_.Right(kMain, Named("random side")), decisions_.Count()).value;
    for (std::size_t rank = 0; rank < kSideCount; ++rank) {
      const auto ranked = [&](int set, int which) {
        return Vote(decisions_.sets()[set].cases[which].sides, planning::PaperVoters(),
                    planning::VoteRule::kPlurality, false, rank);
      };
      rows_.push_back(
          {fmt::format("accuracy from the side that the paper's vote ranks {}", rank + 1),
           BootstrappedRatio(decisions_.Right(kMain, ranked), decisions_.Count()),
           {},
           random});
    }
  }

  const Decisions& decisions_;
  const NbvClassifier& classifier_;
  std::string report_;  // folder of the plots; "": none
  std::vector<NamedChooser> choosers_;
  std::vector<Row> rows_;
};

}  // namespace

std::vector<Row> SummariseNbv(const std::vector<NbvSet>& sets, const NbvClassifier& classifier,
                              const std::string& report) {
  if (sets.empty()) return {};
  const Decisions decisions(sets, classifier);
  return Rows(decisions, classifier, report).All();
}

}  // namespace secondlook::apps
