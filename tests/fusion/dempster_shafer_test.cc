#include "lib/fusion/dempster_shafer.h"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::fusion {
namespace {

using world::MassFunction;

const std::vector<std::string> kClasses{"book", "bowl", "mug"};

MassFunction Random(Rng* rng) {
  MassFunction m;
  m.omega = rng->Uniform(0.01, 1.0);
  double total = m.omega;
  for (const std::string& c : kClasses) total += m.singletons[c] = rng->Uniform(0.0, 1.0);
  m.omega /= total;
  for (auto& [c, mass] : m.singletons) mass /= total;
  return m;
}

double Sum(const MassFunction& m) {
  double sum = m.omega + m.conflict;
  for (const auto& [c, mass] : m.singletons) sum += mass;
  return sum;
}

/// A second method: the rule over all subsets of three classes, as bit sets.
std::vector<double> Subsets(const MassFunction& m) {
  return {m.conflict, m.Of("book"), m.Of("bowl"), 0.0, m.Of("mug"), 0.0, 0.0, m.omega};
}

std::vector<double> CombineSubsets(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result(8, 0.0);
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) result[i & j] += a[i] * b[j];
  }
  return result;
}

TEST(Combine, AgreesWithTheRuleOverAllSubsets) {
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const MassFunction a = Random(&rng);
    const MassFunction b = Random(&rng);
    const MassFunction c = Random(&rng);
    const MassFunction m = Combine(Combine(a, b), c);
    const std::vector<double> expected =
        CombineSubsets(CombineSubsets(Subsets(a), Subsets(b)), Subsets(c));
    const std::vector<double> actual = Subsets(m);
    for (int k = 0; k < 8; ++k) EXPECT_NEAR(actual[k], expected[k], 1e-12) << "subset " << k;
    EXPECT_NEAR(Sum(m), 1.0, 1e-12);
  }
}

TEST(Combine, DoesNotDependOnTheOrderOfTheViews) {
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    const MassFunction a = Random(&rng);
    const MassFunction b = Random(&rng);
    const MassFunction c = Random(&rng);
    const MassFunction first = Combine(Combine(a, b), c);
    const MassFunction second = Combine(c, Combine(b, a));
    for (const std::string& name : kClasses) EXPECT_NEAR(first.Of(name), second.Of(name), 1e-12);
    EXPECT_NEAR(first.conflict, second.conflict, 1e-12);
  }
}

TEST(Combine, LeavesAViewAsItIsWhenTheOtherKnowsNothing) {
  Rng rng(3);
  const MassFunction a = Random(&rng);
  const MassFunction m = Combine(a, MassFunction{});
  for (const std::string& name : kClasses) EXPECT_NEAR(m.Of(name), a.Of(name), 1e-15);
  EXPECT_NEAR(m.omega, a.omega, 1e-15);
}

TEST(Combine, KeepsConflictBetweenTheViewsAsMassOfTheEmptySet) {
  const MassFunction a{{{"mug", 0.9}}, 0.1, 0.0};
  const MassFunction b{{{"bowl", 0.8}}, 0.2, 0.0};
  const MassFunction m = Combine(a, b);
  EXPECT_NEAR(m.conflict, 0.72, 1e-12);
  EXPECT_NEAR(m.Of("mug"), 0.18, 1e-12);
  EXPECT_NEAR(m.Of("bowl"), 0.08, 1e-12);
  EXPECT_NEAR(m.omega, 0.02, 1e-12);
  EXPECT_NEAR(NormalisedBelief(m, "mug"), 0.18 / 0.28, 1e-12);
}

TEST(CommittedConflict, IsTheSameHoweverTheViewsAreDiscounted) {
  const MassFunction a{{{"mug", 0.9}}, 0.1, 0.0};
  const MassFunction b{{{"bowl", 0.6}, {"mug", 0.2}}, 0.2, 0.0};
  EXPECT_NEAR(CommittedConflict(a, b), 0.75, 1e-12);  // of what b says, 0.6 of 0.8 is not the mug
  EXPECT_NEAR(CommittedConflict(Discounted(a, 0.3), Discounted(b, 0.5)), 0.75, 1e-12);
}

TEST(CommittedConflict, IsNoneWhereAViewKnowsNothing) {
  EXPECT_EQ(CommittedConflict({{{"mug", 0.9}}, 0.1, 0.0}, MassFunction{}), 0.0);
}

TEST(FromSupports, SharesTheBeliefBetweenLookAlikes) {
  const MassFunction m = FromSupports({{"mug", 0.9}, {"bowl", 0.9}});
  EXPECT_NEAR(m.Of("mug"), 0.09 / 0.19, 1e-12);
  EXPECT_NEAR(m.Of("bowl"), 0.09 / 0.19, 1e-12);
  EXPECT_NEAR(m.omega, 0.01 / 0.19, 1e-12);
}

TEST(FromSupports, KnowsNothingWhenNothingIsSupported) {
  EXPECT_EQ(FromSupports({}).omega, 1.0);
  EXPECT_EQ(FromSupports({{"mug", 0.0}}).omega, 1.0);
}

TEST(FromSupports, NeverBecomesCertain) { EXPECT_LT(FromSupports({{"mug", 1.0}}).Of("mug"), 1.0); }

TEST(FromSupports, RefusesWhatIsNoSupport) {
  EXPECT_THROWS(FromSupports({{"mug", 1.5}}), InvalidArgument, "class 'mug' is 1.5");
  EXPECT_THROWS(FromSupports({{"mug", std::numeric_limits<double>::quiet_NaN()}}), InvalidArgument,
                "class 'mug' is nan");
}

TEST(Pignistic, SpreadsIgnoranceEvenlyOverAllClasses) {
  const MassFunction m{{{"mug", 0.5}, {"bowl", 0.2}}, 0.1, 0.2};
  const auto p = Pignistic(m, 10);
  EXPECT_NEAR(p.at("mug"), 0.51 / 0.8, 1e-12);
  EXPECT_NEAR(p.at("bowl"), 0.21 / 0.8, 1e-12);
  // The eight others share the rest, so all ten sum to one.
  EXPECT_NEAR(p.at("mug") + p.at("bowl") + 8 * 0.01 / 0.8, 1.0, 1e-12);
}

}  // namespace
}  // namespace secondlook::fusion
