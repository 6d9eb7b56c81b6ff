#pragma once

#include <map>
#include <string>
#include <vector>

#include "lib/world/mass_function.h"

namespace secondlook::fusion {

/// How what a classifier says in several views becomes one decision.
enum class FusionRule {
  kAveraging,          ///< Mean of the probabilities.
  kNaiveBayes,         ///< Their product: views that err independently, classes equally likely.
  kTransferableBelief  ///< The conjunctive rule, un-normalised (Hoseini 2018, Eq. 2 and 3).
};

/// What a classifier says of an object in one view: its probabilities as masses, and that of the
/// class "unknown", where it has one, as m(Omega) (Hoseini 2018, 2.2). They sum to 1.
struct ViewDecision {
  world::MassFunction masses;
  double reliability{1.0};  ///< In [0, 1]; the rest is moved to Omega (Shafer's discounting).
};

struct FusedDecision {
  /// By class, >= 0, sum to 1. Empty when the views leave no class possible: total conflict.
  std::map<std::string, double> probabilities;
  /// By the conjunctive rule, whichever rule made the probabilities: m(empty) near 1 tells of a
  /// wrong match or a new object, m(Omega) of views that know nothing.
  world::MassFunction masses;
};

/// One decision of all views; their order does not matter, and a view that knows nothing (m(Omega)
/// = 1 after discounting) leaves the others as they are. Averaging weighs each view by 1 -
/// m(Omega); naive Bayes, like the pignistic transform, shares a view's m(Omega) out among all
/// classes.
/// @throws InvalidArgument naming view and class: for no view, views of different classes, masses
/// that are negative, NaN, or do not sum to 1 within 1e-6, masses of the empty set, and
/// reliabilities outside [0, 1].
FusedDecision FuseDecisions(FusionRule rule, const std::vector<ViewDecision>& views);

/// The class with the largest probability (the first by name of equals) without those in `except`,
/// e.g. a class for the background; "" when there is none.
std::string MostProbable(const std::map<std::string, double>& probabilities,
                         const std::vector<std::string>& except = {});

/// The largest probability over the second largest (Hoseini 2018, 2); infinity when only one class
/// is possible, 0 for no class. Below its threshold a second look is due.
double ConfidenceRatio(const std::map<std::string, double>& probabilities);

}  // namespace secondlook::fusion
