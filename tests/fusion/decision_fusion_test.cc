#include "lib/fusion/decision_fusion.h"

#include <array>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::fusion {
namespace {

constexpr std::array kRules{FusionRule::kAveraging, FusionRule::kNaiveBayes,
                            FusionRule::kTransferableBelief};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

ViewDecision View(double bowl, double cup, double mug, double unknown = 0.0,
                  double reliability = 1.0) {
  return {{{{"bowl", bowl}, {"cup", cup}, {"mug", mug}}, unknown, 0.0}, reliability};
}

ViewDecision RandomView(Rng* rng) {
  std::array<double, 4> mass{};
  double sum = 0.0;
  for (double& m : mass) sum += m = rng->Uniform(0.0, 1.0);
  return View(mass[0] / sum, mass[1] / sum, mass[2] / sum, mass[3] / sum, rng->Uniform(0.0, 1.0));
}

double Sum(const std::map<std::string, double>& values) {
  double sum = 0.0;
  for (const auto& [c, value] : values) sum += value;
  return sum;
}

void ExpectEqual(const FusedDecision& actual, const FusedDecision& expected) {
  for (const auto& [c, probability] : expected.probabilities) {
    EXPECT_NEAR(actual.probabilities.at(c), probability, 1e-12) << c;
    EXPECT_NEAR(actual.masses.Of(c), expected.masses.Of(c), 1e-12) << c;
  }
  EXPECT_NEAR(actual.masses.conflict, expected.masses.conflict, 1e-12);
}

TEST(FuseDecisions, GivesProbabilitiesAndMassesThatSumToOneForAnyNumberOfViews) {
  Rng rng(1);
  for (const FusionRule rule : kRules) {
    std::vector<ViewDecision> views;
    for (int i = 0; i < 6; ++i) {
      views.push_back(RandomView(&rng));
      const FusedDecision fused = FuseDecisions(rule, views);
      EXPECT_NEAR(Sum(fused.probabilities), 1.0, 1e-12);
      const world::MassFunction& m = fused.masses;
      EXPECT_NEAR(Sum(m.singletons) + m.omega + m.conflict, 1.0, 1e-12);
    }
  }
}

TEST(FuseDecisions, DoesNotDependOnTheOrderOfTheViews) {
  Rng rng(2);
  for (const FusionRule rule : kRules) {
    const ViewDecision a = RandomView(&rng);
    const ViewDecision b = RandomView(&rng);
    const ViewDecision c = RandomView(&rng);
    ExpectEqual(FuseDecisions(rule, {a, b, c}), FuseDecisions(rule, {c, a, b}));
  }
}

TEST(FuseDecisions, IgnoresAViewThatKnowsNothing) {
  Rng rng(3);
  for (const FusionRule rule : kRules) {
    const ViewDecision a = RandomView(&rng);
    const ViewDecision b = RandomView(&rng);
    const FusedDecision expected = FuseDecisions(rule, {a, b});
    ExpectEqual(FuseDecisions(rule, {a, View(0.0, 0.0, 0.0, 1.0), b}), expected);
    ExpectEqual(FuseDecisions(rule, {a, b, View(1.0, 0.0, 0.0, 0.0, 0.0)}), expected);
  }
}

TEST(FuseDecisions, LeavesClassesEquallyLikelyWhenNoViewKnowsAnything) {
  for (const FusionRule rule : kRules) {
    const FusedDecision fused = FuseDecisions(rule, {View(0.0, 0.0, 0.0, 1.0)});
    EXPECT_NEAR(fused.probabilities.at("cup"), 1.0 / 3.0, 1e-12);
    EXPECT_EQ(fused.masses.omega, 1.0);
  }
}

/// The second method: both combination and pignistic transform over all eight subsets of three
/// classes, as bit sets.
std::vector<double> PignisticOverAllSubsets(const std::vector<ViewDecision>& views) {
  std::vector<double> m{0, 0, 0, 0, 0, 0, 0, 1};
  for (const ViewDecision& view : views) {
    const double r = view.reliability;
    const world::MassFunction& v = view.masses;
    const std::vector<double> other{0.0, r * v.Of("bowl"),     r * v.Of("cup"),
                                    0.0, r * v.Of("mug"),      0.0,
                                    0.0, 1.0 - r + r * v.omega};
    std::vector<double> combined(8, 0.0);
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j < 8; ++j) combined[i & j] += m[i] * other[j];
    }
    m = combined;
  }
  std::vector<double> p(3, 0.0);
  for (unsigned set = 1; set < 8; ++set) {
    for (int c = 0; c < 3; ++c) {
      if (set >> c & 1U) p[c] += m[set] / __builtin_popcount(set) / (1.0 - m[0]);
    }
  }
  return p;
}

TEST(FuseDecisions, AgreesWithTheTransferableBeliefModelOverThePowerSet) {
  Rng rng(4);
  for (int i = 0; i < 50; ++i) {
    const std::vector<ViewDecision> views{RandomView(&rng), RandomView(&rng), RandomView(&rng)};
    const auto p = FuseDecisions(FusionRule::kTransferableBelief, views).probabilities;
    const std::vector<double> expected = PignisticOverAllSubsets(views);
    EXPECT_NEAR(p.at("bowl"), expected[0], 1e-12);
    EXPECT_NEAR(p.at("cup"), expected[1], 1e-12);
    EXPECT_NEAR(p.at("mug"), expected[2], 1e-12);
  }
}

TEST(FuseDecisions, AveragesAndMultiplies) {
  const std::vector<ViewDecision> views{View(0.6, 0.3, 0.1), View(0.2, 0.7, 0.1)};
  const auto average = FuseDecisions(FusionRule::kAveraging, views).probabilities;
  EXPECT_NEAR(average.at("bowl"), 0.4, 1e-12);
  EXPECT_NEAR(average.at("cup"), 0.5, 1e-12);
  const auto product = FuseDecisions(FusionRule::kNaiveBayes, views).probabilities;
  EXPECT_NEAR(product.at("bowl"), 0.12 / 0.34, 1e-12);
  EXPECT_NEAR(product.at("cup"), 0.21 / 0.34, 1e-12);
}

TEST(FuseDecisions, SurvivesTheProductOfManyViews) {
  const std::vector<ViewDecision> views(2000, View(0.4, 0.35, 0.25));
  for (const FusionRule rule : {FusionRule::kNaiveBayes, FusionRule::kTransferableBelief}) {
    EXPECT_NEAR(FuseDecisions(rule, views).probabilities.at("bowl"), 1.0, 1e-12);
  }
}

TEST(FuseDecisions, TellsTotalConflictByMassOfTheEmptySet) {
  const std::vector<ViewDecision> views{View(1.0, 0.0, 0.0), View(0.0, 1.0, 0.0)};
  for (const FusionRule rule : kRules) EXPECT_EQ(FuseDecisions(rule, views).masses.conflict, 1.0);
  EXPECT_TRUE(FuseDecisions(FusionRule::kNaiveBayes, views).probabilities.empty());
  EXPECT_TRUE(FuseDecisions(FusionRule::kTransferableBelief, views).probabilities.empty());
  EXPECT_EQ(FuseDecisions(FusionRule::kAveraging, views).probabilities.at("bowl"), 0.5);
}

TEST(FuseDecisions, RefusesWhatIsNoDecision) {
  const ViewDecision good = View(0.2, 0.3, 0.5);
  const auto fuse = [&](const ViewDecision& view) {
    return FuseDecisions(FusionRule::kAveraging, {good, view});
  };
  EXPECT_THROWS(FuseDecisions(FusionRule::kAveraging, {}), InvalidArgument, "no view to fuse");
  EXPECT_THROWS(fuse(View(kNan, 0.5, 0.5)), InvalidArgument,
                "view 2: class 'bowl' has the probability nan");
  EXPECT_THROWS(fuse(View(0.0, 0.0, 0.0)), InvalidArgument, "view 2: its probabilities sum to 0");
  EXPECT_THROWS(fuse(View(-0.5, 1.0, 0.5)), InvalidArgument,
                "class 'bowl' has the probability -0.5");
  EXPECT_THROWS(fuse(View(0.5, 0.5, 0.0, 0.0, 1.5)), InvalidArgument, "its reliability is 1.5");
  EXPECT_THROWS(fuse({{{{"bowl", 1.0}}, 0.0, 0.0}}), InvalidArgument,
                "has 1 classes, view 1 has 3");
  EXPECT_THROWS(fuse({{{{"duck", 1.0}}, 0.0, 0.0}}), InvalidArgument,
                "class 'duck' is none of view 1");
}

TEST(ConfidenceRatio, IsTheLargestProbabilityOverTheSecond) {
  EXPECT_NEAR(ConfidenceRatio({{"bowl", 0.1}, {"cup", 0.6}, {"mug", 0.3}}), 2.0, 1e-12);
  EXPECT_EQ(ConfidenceRatio({{"bowl", 0.5}, {"cup", 0.5}}), 1.0);
  EXPECT_EQ(ConfidenceRatio({{"bowl", 1.0}}), std::numeric_limits<double>::infinity());
  EXPECT_EQ(ConfidenceRatio({}), 0.0);
}

TEST(MostProbable, LeavesOutWhatItIsTold) {
  const std::map<std::string, double> p{{"Background", 0.6}, {"cup", 0.3}, {"mug", 0.1}};
  EXPECT_EQ(MostProbable(p), "Background");
  EXPECT_EQ(MostProbable(p, {"Background"}), "cup");
  EXPECT_EQ(MostProbable({}), "");
}

}  // namespace
}  // namespace secondlook::fusion
