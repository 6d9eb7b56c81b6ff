#include "lib/planning/expected_loss.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

/// Wrong costs 10, unsettled 1, incomplete 0.3.
const LossConfig kLoss;

Belief Of(std::vector<double> probabilities) {
  Belief belief;
  for (const double p : probabilities) belief.alternatives.push_back({p});
  return belief;
}

/// The same evidence between any two of `count` alternatives.
Prospect Telling(int count, double evidence, double probability = 1.0) {
  Prospect prospect;
  prospect.probability = probability;
  prospect.evidence = Eigen::MatrixXd::Constant(count, count, evidence);
  return prospect;
}

double Gain(const Belief& belief, const std::vector<Prospect>& prospects) {
  return Loss(belief, kLoss) - ExpectedLoss(Outcomes(belief, prospects), kLoss);
}

TEST(Loss, IsThatOfTheBestDecision) {
  EXPECT_NEAR(Loss(Of({0.5, 0.5}), kLoss), 1.0, 1e-12) << "left open";
  EXPECT_NEAR(Loss(Of({0.9, 0.1}), kLoss), 1.0, 1e-12) << "open or wrong: the same";
  EXPECT_NEAR(Loss(Of({0.98, 0.02}), kLoss), 0.2, 1e-12) << "wrong in one of fifty";
  EXPECT_NEAR(Loss(Of({1.0, 0.0}), kLoss), 0.0, 1e-12);
}

TEST(Loss, OfWhatNobodyHasLookedAtComesOnTop) {
  EXPECT_NEAR(Loss({{}, 0.5}, kLoss), 0.15, 1e-12);
  Belief belief = Of({0.5, 0.5});
  belief.incomplete = 1.0;
  EXPECT_NEAR(Loss(belief, kLoss), 1.3, 1e-12);
}

TEST(Loss, NothingIsDecidedBelowTheProbabilityItNeeds) {
  Belief medicine = Of({0.98, 0.02});
  medicine.alternatives[0].needed = 0.99;
  EXPECT_NEAR(Loss(medicine, kLoss), 1.0, 1e-12);
  medicine.alternatives[0].probability = 0.995;
  EXPECT_NEAR(Loss(medicine, kLoss), 0.5, 1e-12) << "wrong costs 100 now";
}

TEST(Outcomes, KeepWhatIsBelievedOnAverage) {
  for (const double evidence : {0.1, 1.0, 3.0}) {
    double sum = 0.0;
    double mean = 0.0;
    for (const Outcome& outcome : Outcomes(Of({0.7, 0.3}), {Telling(2, evidence)})) {
      sum += outcome.probability;
      mean += outcome.probability * outcome.belief.alternatives[0].probability;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    EXPECT_NEAR(mean, 0.7, 0.01) << evidence;
  }
}

TEST(Outcomes, OfAverageLuckFollowBayes) {
  // Evidence of 2 nat for the first: odds 7 : 3 become 7 e^2 : 3.
  const std::vector<Outcome> outcomes = Outcomes(Of({0.7, 0.3}), {Telling(2, 2.0)});
  ASSERT_EQ(outcomes.size(), 10U);
  const double odds = 7.0 / 3.0 * std::exp(2.0);
  EXPECT_NEAR(outcomes[2].belief.alternatives[0].probability, odds / (1.0 + odds), 1e-12);
  EXPECT_NEAR(outcomes[2].probability, 0.7 * 0.5333333333333333, 1e-12);
}

TEST(ExpectedLoss, WhereAllLookAlikeNothingIsGained) {
  EXPECT_NEAR(Gain(Of({0.5, 0.5}), {Telling(2, 0.0)}), 0.0, 1e-12);
  EXPECT_NEAR(Gain(Of({0.3, 0.3, 0.4}), {Telling(3, 0.0)}), 0.0, 1e-12);
}

TEST(ExpectedLoss, MoreEvidenceGainsMoreAndAllOfItAllThatIsAtStake) {
  double before = 0.0;
  for (const double evidence : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    const double gain = Gain(Of({0.5, 0.5}), {Telling(2, evidence)});
    EXPECT_GT(gain, before) << evidence;
    before = gain;
  }
  EXPECT_NEAR(Gain(Of({0.5, 0.5}), {Telling(2, 200.0)}), 1.0, 1e-6);
}

TEST(ExpectedLoss, TellingTheUnlikelyApartIsWorthLittle) {
  // Of three, only the first two look different from there.
  Prospect prospect = Telling(3, 0.0);
  prospect.evidence(0, 1) = prospect.evidence(1, 0) = 100.0;
  EXPECT_NEAR(Gain(Of({0.48, 0.48, 0.04}), {prospect}), 0.96 * (1.0 - 10.0 * 0.04 / 0.52), 1e-3);
  EXPECT_NEAR(Gain(Of({0.1, 0.1, 0.8}), {prospect}), 0.0, 1e-6) << "0.8 / 0.9 is not enough";
}

TEST(ExpectedLoss, AViewThatMayBeHiddenGainsByItsChance) {
  const double open = Gain(Of({0.5, 0.5}), {Telling(2, 5.0)});
  EXPECT_NEAR(Gain(Of({0.5, 0.5}), {Telling(2, 5.0, 0.25), Telling(2, 0.0, 0.75)}), 0.25 * open,
              1e-12);
}

TEST(ExpectedLossAfter, IsTheExpectedLossOfTheOutcomes) {
  // 0.3 / 0.05 / 0.65, one of which needs more than the others.
  Belief belief = Of({0.3, 0.05, 0.65});
  belief.alternatives[1].needed = 0.99;
  belief.incomplete = 0.5;
  std::vector<Prospect> prospects{Telling(3, 2.0, 0.4), Telling(3, 0.5, 0.6)};
  prospects[0].evidence(0, 2) = prospects[0].evidence(2, 0) = 0.0;
  EXPECT_NEAR(ExpectedLossAfter(belief, Readings(prospects, 3), kLoss),
              ExpectedLoss(Outcomes(belief, prospects), kLoss), 1e-12);
}

TEST(GainPerSecond, WeighsLooksOfEveryKindByTheirTime) {
  // A scan that completes half of what is missing, in 20 s.
  const Belief prior{{}, 1.0};
  EXPECT_NEAR(GainPerSecond(prior, {{1.0, {{}, 0.5}}}, 20.0, kLoss), 0.15 / 20.0, 1e-12);
  EXPECT_THROWS(GainPerSecond(prior, {}, 0.0, kLoss), InvalidArgument, "a look of 0 s");
}

TEST(ExpectedLoss, RefusesBadInput) {
  EXPECT_THROWS(Outcomes(Of({0.5, 0.5}), {Telling(3, 1.0)}), InvalidArgument,
                "is 3 x 3 for 2 alternatives");
  EXPECT_THROWS(Outcomes(Of({0.5, 0.5}), {Telling(2, NAN)}), InvalidArgument, "not negative");
  LossConfig config;
  config.wrong = -1.0;
  EXPECT_THROWS(config.Validate(), ConfigError, "wrong = -1 must lie in 0..");
}

}  // namespace
}  // namespace secondlook::planning
