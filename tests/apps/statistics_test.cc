#include "apps/experiments/statistics.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::apps {
namespace {

TEST(Proportion, HasWilsonsIntervalOfHandComputedCases) {
  // z^2 = 3.841459. 8 of 10: centre (0.8 + 0.1920729) / 1.3841459 = 0.7167402, half width
  // 1.959964 / 1.3841459 sqrt(0.016 + 0.00960365) = 0.2265778.
  const Estimate some = Proportion(8, 10);
  EXPECT_DOUBLE_EQ(some.value, 0.8);
  EXPECT_NEAR(some.low, 0.4901625, 1e-6);
  EXPECT_NEAR(some.high, 0.9433178, 1e-6);
  // None of 20: [0, z^2 / (20 + z^2)].
  const Estimate none = Proportion(0, 20);
  EXPECT_NEAR(none.low, 0.0, 1e-12);
  EXPECT_NEAR(none.high, 3.841459 / 23.841459, 1e-6);
  // All of 20: [20 / (20 + z^2), 1].
  const Estimate all = Proportion(20, 20);
  EXPECT_NEAR(all.low, 20.0 / 23.841459, 1e-6);
  EXPECT_NEAR(all.high, 1.0, 1e-12);
}

TEST(Proportion, OfNothingMayBeAnything) {
  const Estimate nothing = Proportion(0, 0);
  EXPECT_EQ(nothing.low, 0.0);
  EXPECT_EQ(nothing.high, 1.0);
}

TEST(Proportion, LiesWithinItsIntervalAndMirrorsItsOpposite) {
  Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const int count = 1 + rng.Index(100);
    const int hits = rng.Index(count + 1);
    const Estimate estimate = Proportion(hits, count);
    EXPECT_LE(0.0, estimate.low);
    EXPECT_LE(estimate.low, estimate.value + 1e-12);
    EXPECT_LE(estimate.value, estimate.high + 1e-12);
    EXPECT_LE(estimate.high, 1.0);
    const Estimate opposite = Proportion(count - hits, count);
    EXPECT_NEAR(estimate.low, 1.0 - opposite.high, 1e-12);
    EXPECT_NEAR(estimate.high, 1.0 - opposite.low, 1e-12);
  }
}

TEST(Mean, HasTheNormalIntervalOfItsStandardError) {
  // 1, 2, 3, 4: variance 5/3, standard error sqrt(5/12) = 0.6454972.
  const Estimate mean = Mean({1.0, 2.0, 3.0, 4.0});
  EXPECT_DOUBLE_EQ(mean.value, 2.5);
  EXPECT_NEAR(mean.low, 2.5 - 1.959964 * 0.6454972, 1e-6);
  EXPECT_NEAR(mean.high, 2.5 + 1.959964 * 0.6454972, 1e-6);
}

TEST(Mean, OfOneValueIsThatValueAndOfNoneIsNoNumber) {
  EXPECT_EQ(Mean({3.0}).low, 3.0);
  EXPECT_EQ(Mean({3.0}).high, 3.0);
  EXPECT_TRUE(std::isnan(Mean({}).value));
}

TEST(BootstrappedMean, IsTheMeanWithAnIntervalAboutAsWideAsTheNormalOne) {
  Rng rng(7);
  std::vector<double> values;
  for (int i = 0; i < 200; ++i) values.push_back(3.0 + rng.Gaussian(2.0));
  const Estimate normal = Mean(values);
  const Estimate bootstrapped = BootstrappedMean(values);
  EXPECT_NEAR(bootstrapped.value, normal.value, 1e-12);
  EXPECT_NEAR(bootstrapped.low, normal.low, 0.08);
  EXPECT_NEAR(bootstrapped.high, normal.high, 0.08);
  EXPECT_EQ(BootstrappedMean(values).low, bootstrapped.low) << "nothing is left to chance";
  EXPECT_TRUE(std::isnan(BootstrappedMean({}).value));
}

TEST(BootstrappedRatio, IsThatOfTheSums) {
  const Estimate ratio = BootstrappedRatio({1.0, 3.0}, {4.0, 4.0});
  EXPECT_DOUBLE_EQ(ratio.value, 0.5);
  EXPECT_DOUBLE_EQ(ratio.low, 0.25);
  EXPECT_DOUBLE_EQ(ratio.high, 0.75);
}

}  // namespace
}  // namespace secondlook::apps
