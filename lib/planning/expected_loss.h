#pragma once

#include <vector>

#include <Eigen/Core>

namespace secondlook::planning {

/// What a task loses by how things are left, in any one unit: the one currency in which looks of
/// every kind are weighed. The values are a task's to set, not to be measured: these say that a
/// wrong name costs as much as ten open ones, and a look of 20 s pays when it saves a hundredth of
/// one.
struct LossConfig {
  double wrong{10.0};      ///< By a thing that is called what it is not.
  double unsettled{1.0};   ///< By a thing that is left open.
  double incomplete{0.3};  ///< By what nobody has looked at, e.g. where a thing may stand hidden; a
                           ///< part counts by its share.
  double per_second{5e-4};  ///< A look that saves less than this a second is not worth its time.

  template <class A>
  void Serialize(A* a) {
    a->Visit("wrong", &wrong);
    a->Visit("unsettled", &unsettled);
    a->Visit("incomplete", &incomplete);
    a->Visit("per_second", &per_second);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// Something that may be true of a thing, e.g. that a model stands there at a pose.
struct Alternative {
  double probability{};
  double needed{0.9};  ///< The task decides for it from this probability on, in [0, 1).
};

/// What is believed of one thing: alternatives of which exactly one is true, and how much of it has
/// not been seen.
struct Belief {
  std::vector<Alternative> alternatives;  ///< Probabilities sum to 1, or there are none.
  double incomplete{};                    ///< Share in [0, 1].
};

/// One way a look may turn out, and what would be believed then.
struct Outcome {
  double probability{};
  Belief belief;
};

/// What a view may show of the alternatives, with the chance that it does.
struct Prospect {
  double probability{1.0};
  /// [n, n], >= 0 [nat]: (i, j) is the evidence for i against j that the view is expected to give
  /// when i is true. 0: they look alike from there.
  Eigen::MatrixXd evidence;
};

/// The loss of the best decision on `belief`: to leave the thing open, or to decide for an
/// alternative and be wrong with the probability of all others; the cost of being wrong is such
/// that nothing is decided below the probability that it needs. What is incomplete comes on top.
double Loss(const Belief& belief, const LossConfig& config);

double ExpectedLoss(const std::vector<Outcome>& outcomes, const LossConfig& config);

/// What a view may say: of every alternative how likely that is, up to a factor.
struct Reading {
  double probability{};  ///< When `truth` is true.
  int truth{};
  std::vector<double> likelihoods;  ///< One an alternative.
};

/// For every alternative that may be true and for the luck of the view what it may say: evidence k
/// comes out normal, with mean k and variance 2 k, as that of n independent Gaussian measurements
/// does. For each truth the probabilities sum to 1.
/// @throws InvalidArgument when a prospect's evidence does not fit the alternatives.
std::vector<Reading> Readings(const std::vector<Prospect>& prospects, int alternatives);

/// What would be believed after each of the Readings(). The probabilities sum to 1.
/// @throws InvalidArgument likewise.
std::vector<Outcome> Outcomes(const Belief& prior, const std::vector<Prospect>& prospects);

/// ExpectedLoss() of the Outcomes() of these `readings`, for less work where the same view is
/// weighed for many beliefs.
/// @pre the readings are about as many alternatives.
double ExpectedLossAfter(const Belief& prior, const std::vector<Reading>& readings,
                         const LossConfig& config);

/// The expected drop of the loss by a look with these outcomes, per second that it takes: the same
/// for a view that tells poses apart, a vote that sharpens a class and a scan that completes a
/// model.
/// @throws InvalidArgument when `seconds` is not positive.
double GainPerSecond(const Belief& prior, const std::vector<Outcome>& outcomes, double seconds,
                     const LossConfig& config);

}  // namespace secondlook::planning
