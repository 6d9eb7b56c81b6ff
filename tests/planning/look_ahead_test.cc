#include "lib/planning/look_ahead.h"

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

const LossConfig kLoss;
const LookAheadConfig kConfig;

Belief Even(int count) {
  Belief belief;
  for (int i = 0; i < count; ++i) belief.alternatives.push_back({1.0 / count});
  return belief;
}

/// A look that tells alternatives a and b of `count` apart from all others, as a group.
LookOption TellsGroup(int count, int a, int b, double seconds) {
  LookOption option{seconds, {{1.0, Eigen::MatrixXd::Zero(count, count)}}};
  const auto in = [&](int i) { return i == a || i == b; };
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      if (in(i) != in(j)) option.prospects[0].evidence(i, j) = 100.0;
    }
  }
  return option;
}

TEST(LookAhead, FindsTwoLooksOfWhichNeitherSettlesAnythingByItself) {
  // Four alternatives: one look tells {0, 1} from {2, 3}, another {0, 2} from {1, 3}.
  const std::vector<LookOption> options{TellsGroup(4, 0, 1, 10.0), TellsGroup(4, 0, 2, 10.0)};
  const auto near = [](int, int) { return Sequel{5.0, 1.0}; };
  const std::vector<double> gains = GainsLookingAhead(Even(4), options, near, kLoss, kConfig);
  EXPECT_NEAR(GainPerSecond(Even(4), Outcomes(Even(4), options[0].prospects), 10.0, kLoss), 0.0,
              1e-9);
  // Together they settle it, whatever is true: a loss of 1 in 10 s + 5 s.
  EXPECT_NEAR(gains[0], 1.0 / 15.0, 1e-6);
  EXPECT_NEAR(gains[1], 1.0 / 15.0, 1e-6);
}

TEST(LookAhead, IsOfNoUseWhereOneLookSettlesAll) {
  const LookOption both = TellsGroup(2, 0, 0, 10.0);
  const auto near = [](int, int) { return Sequel{1.0, 1.0}; };
  const std::vector<double> gains = GainsLookingAhead(Even(2), {both, both}, near, kLoss, kConfig);
  EXPECT_NEAR(gains[0], 0.1, 1e-6);
}

TEST(LookAhead, TakesTheSecondLookOnlyWhereItPays) {
  const std::vector<LookOption> options{TellsGroup(4, 0, 1, 10.0), TellsGroup(4, 0, 2, 10.0)};
  const auto far = [](int, int) { return Sequel{1000.0, 1.0}; };
  const std::vector<double> gains = GainsLookingAhead(Even(4), options, far, kLoss, kConfig);
  EXPECT_NEAR(gains[0], 1.0 / 1010.0, 1e-6);
  const auto same_again = [](int, int) { return Sequel{5.0, 0.0}; };
  EXPECT_NEAR(GainsLookingAhead(Even(4), options, same_again, kLoss, kConfig)[0], 0.0, 1e-9);
}

TEST(LookAhead, LooksNoFurtherThanItIsTold) {
  const std::vector<LookOption> options{TellsGroup(4, 0, 1, 10.0), TellsGroup(4, 0, 2, 10.0)};
  const auto near = [](int, int) { return Sequel{5.0, 1.0}; };
  EXPECT_NEAR(GainsLookingAhead(Even(4), options, near, kLoss, {0, 8})[0], 0.0, 1e-9);
  EXPECT_TRUE(GainsLookingAhead(Even(4), {}, near, kLoss, kConfig).empty());
  EXPECT_THROWS((LookAheadConfig{-1, 8}.Validate()), ConfigError, "firsts = -1 must lie in 0..");
}

}  // namespace
}  // namespace secondlook::planning
