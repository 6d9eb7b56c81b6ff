#include "apps/experiments/nbv_measures.h"

#include <algorithm>
#include <cmath>

#include "lib/common/rng.h"

namespace secondlook::apps::nbv {

using fusion::FusionRule;

std::vector<Tally> TallyAll(const Decisions& decisions, std::size_t classes, const Chooser& chooser,
                            double gate) {
  std::vector<Tally> tallies;
  for (int i = 0; i < decisions.set_count(); ++i) {
    Tally& tally = tallies.emplace_back();
    tally.said.assign(classes, 0.0);
    for (int k = 0; k < std::ssize(decisions.sets()[i].cases); ++k) {
      for (const Shared& s : decisions.Result(FusionRule::kNaiveBayes, chooser, i, k, gate)) {
        if (s.decision->said < 0) continue;
        tally.said[s.decision->said] += s.share;
        const int bin =
            std::min(static_cast<int>(s.decision->confidence * Tally::kBins), Tally::kBins - 1);
        tally.count[bin] += s.share;
        tally.confidence[bin] += s.share * s.decision->confidence;
        if (s.decision->said == decisions.sets()[i].truth) tally.right[bin] += s.share;
      }
    }
  }
  return tallies;
}

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

double CalibrationError(const std::vector<Tally>& tallies, const std::vector<int>& drawn) {
  double error = 0.0;
  double all = 0.0;
  for (int bin = 0; bin < Tally::kBins; ++bin) {
    double difference = 0.0;
    for (const int i : drawn) {
      difference += tallies[i].confidence[bin] - tallies[i].right[bin];
      all += tallies[i].count[bin];
    }
    error += std::abs(difference);
  }
  return all > 0.0 ? error / all : 0.0;
}

void RocTally::Add(double probability, bool true_class, double weight) {
  constexpr double kMaxLogOdds = 20.0;
  const double p = std::clamp(probability, 1e-12, 1.0 - 1e-12);
  const double share = 0.5 + 0.5 * std::log(p / (1.0 - p)) / kMaxLogOdds;
  const int bin = std::clamp(static_cast<int>(share * kBins), 0, kBins - 1);
  (true_class ? positive : negative)[bin] += weight;
}

std::vector<RocTally> RocTallies(const Decisions& decisions, const Chooser& chooser, double gate) {
  std::vector<RocTally> tallies(decisions.sets().size());
  for (int i = 0; i < decisions.set_count(); ++i) {
    for (int k = 0; k < std::ssize(decisions.sets()[i].cases); ++k) {
      for (const Shared& s : decisions.Result(FusionRule::kNaiveBayes, chooser, i, k, gate)) {
        const std::vector<double>& p = s.decision->probabilities;
        for (int c = 0; c < std::ssize(p); ++c) {
          tallies[i].Add(p[c], c == decisions.sets()[i].truth, s.share);
        }
      }
    }
  }
  return tallies;
}

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

Conflicts DrawConflicts(const Decisions& decisions) {
  constexpr int kDraws = 1000;
  Conflicts conflicts;
  Rng rng(1);
  const std::vector<NbvSet>& sets = decisions.sets();
  for (int draw = 0; draw < kDraws; ++draw) {
    const int i = rng.Index(decisions.set_count());
    const int other = rng.Index(decisions.set_count());
    const int which = rng.Index(static_cast<int>(sets[i].cases.size()));
    const auto side = static_cast<std::size_t>(rng.Index(kSideCount));
    if (sets[other].truth == sets[i].truth) continue;
    conflicts.right.push_back(decisions.Conflict(i, which, i, side));
    conflicts.wrong.push_back(decisions.Conflict(i, which, other, side));
  }
  return conflicts;
}

double AreaUnderCurve(const Conflicts& conflicts) {
  double wins = 0.0;
  for (const double wrong : conflicts.wrong) {
    for (const double right : conflicts.right) {
      wins += wrong > right ? 1.0 : (wrong == right ? 0.5 : 0.0);
    }
  }
  return wins / static_cast<double>(conflicts.wrong.size() * conflicts.right.size());
}

}  // namespace secondlook::apps::nbv
