#include "apps/experiments/reliability.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::apps {
namespace {

TEST(Reliability, CountsWhatIsRightByTenthsOfProbability) {
  const std::vector<Predictions> trials{{{0.95, true}, {0.91, false}, {1.0, true}},
                                        {{0.9, true}, {0.0, false}}};
  EXPECT_DOUBLE_EQ(ShareRight(trials, 9).value, 0.75);
  EXPECT_DOUBLE_EQ(ShareRight(trials, 0).value, 0.0);
  EXPECT_TRUE(std::isnan(ShareRight(trials, 5).value));
}

TEST(Reliability, HasTheErrorsOfAHandComputedCase) {
  // Tenth 9: mean 0.925, one of two right; tenth 2: mean 0.2, none of one.
  const std::vector<Predictions> trials{{{0.95, true}, {0.9, false}}, {{0.2, false}}};
  EXPECT_NEAR(CalibrationError(trials).value, (2.0 * 0.425 + 0.2) / 3.0, 1e-12);
  EXPECT_NEAR(BrierScore(trials).value, (0.0025 + 0.81 + 0.04) / 3.0, 1e-12);
}

TEST(Reliability, IsPerfectForWhatHappensAsOftenAsSaid) {
  Rng rng(1);
  std::vector<Predictions> trials(20);
  std::vector<Predictions> boasts(20);
  for (std::size_t t = 0; t < trials.size(); ++t) {
    for (int i = 0; i < 500; ++i) {
      const double p = rng.Uniform(0.0, 1.0);
      const bool right = rng.Uniform(0.0, 1.0) < p;
      trials[t].push_back({p, right});
      boasts[t].push_back({std::sqrt(p), right});
    }
  }
  EXPECT_LT(CalibrationError(trials).value, 0.02);
  EXPECT_NEAR(BrierScore(trials).value, 1.0 / 6.0, 0.01);  // the integral of p (1 - p)
  EXPECT_GT(CalibrationError(boasts).low, 0.1);            // on average 2/3 - 1/2
  EXPECT_GT(BrierScore(boasts).low, BrierScore(trials).high);
}

TEST(Reliability, OfNothingIsUnknown) {
  EXPECT_TRUE(std::isnan(CalibrationError({{}, {}}).value));
  EXPECT_TRUE(std::isnan(BrierScore({}).value));
}

}  // namespace
}  // namespace secondlook::apps
