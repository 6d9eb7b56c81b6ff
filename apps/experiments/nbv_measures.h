#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "apps/experiments/nbv_decisions.h"

namespace secondlook::apps::nbv {

/// What goes into precision, recall and calibration, of one set.
struct Tally {
  static constexpr int kBins = 15;  ///< Of the calibration error.
  std::vector<double> said;         ///< Weight by class said; the truth is the set's.
  std::array<double, kBins> count{};
  std::array<double, kBins> confidence{};
  std::array<double, kBins> right{};
};

/// By set, with naive Bayes and second views where the first view's ratio is below `gate`.
/// @param classes How many there are.
std::vector<Tally> TallyAll(const Decisions& decisions, std::size_t classes, const Chooser& chooser,
                            double gate);

struct Macro {
  double precision{};
  double recall{};
  double f1{};  ///< Mean of the classes' own.
};

/// Over the classes that occur; one that is never said has precision 0. `drawn` are indices of
/// sets, some perhaps more than once, here and below.
Macro MacroOf(const std::vector<Tally>& tallies, const std::vector<NbvSet>& sets,
              const std::vector<int>& drawn);

/// The expected calibration error; 0 without decisions.
double CalibrationError(const std::vector<Tally>& tallies, const std::vector<int>& drawn);

/// The probabilities of true and of other classes, by their log odds: of a set.
struct RocTally {
  static constexpr int kBins = 400;
  std::vector<double> positive = std::vector<double>(kBins, 0.0);
  std::vector<double> negative = std::vector<double>(kBins, 0.0);

  /// @param probability In [0, 1].
  void Add(double probability, bool true_class, double weight);
};

/// Every class of every decision is one that is told or not (micro-averaging); by set.
std::vector<RocTally> RocTallies(const Decisions& decisions, const Chooser& chooser, double gate);

/// (false positive rate, true positive rate), from (0, 0) to (1, 1).
std::vector<Eigen::Vector2d> RocCurve(const std::vector<RocTally>& tallies,
                                      const std::vector<int>& drawn);

double AreaUnder(const std::vector<Eigen::Vector2d>& curve);

/// m(empty) of a view and one of the same object, and of a view and one of another class: as many
/// draws as there are.
struct Conflicts {
  std::vector<double> right;
  std::vector<double> wrong;
};

Conflicts DrawConflicts(const Decisions& decisions);

/// The chance that a wrong match has more conflict than a right one.
double AreaUnderCurve(const Conflicts& conflicts);

}  // namespace secondlook::apps::nbv
