#include "lib/perception/posterior.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::perception {
namespace {

using world::Hypothesis;

Hypothesis Scored(const std::string& model, double score, bool accepted = true) {
  Hypothesis h;
  h.model = model;
  h.score = score;
  h.verification.accepted = accepted;
  return h;
}

/// Takes the odds of the scores as they are, and those of none of them as 1 : 1.
PosteriorConfig Plain() { return {1.0, 0.0, 0.0, 0.0}; }

TEST(Posterior, SharesOneOutByTheOddsAndLeavesSomeToNoneOfThem) {
  // Odds of 3, 1 and, for none of them, 1: 3/5 and 1/5.
  std::vector<Hypothesis> hypotheses{Scored("mug", 0.75), Scored("can", 0.5)};
  SetProbabilities(Plain(), &hypotheses);
  EXPECT_NEAR(hypotheses[0].probability, 0.6, 1e-12);
  EXPECT_NEAR(hypotheses[1].probability, 0.2, 1e-12);
}

TEST(Posterior, CountsScoresByTheirSlopeAndFailedChecksAgainst) {
  PosteriorConfig config = Plain();
  config.slope = 0.5;
  config.failed_check = std::log(2.0);
  config.none = std::log(4.0);
  // Odds of 9^0.5 = 3, 4^0.5 / 2 = 1 and 4.
  std::vector<Hypothesis> hypotheses{Scored("mug", 0.9), Scored("can", 0.8, false)};
  SetProbabilities(config, &hypotheses);
  EXPECT_NEAR(hypotheses[0].probability, 3.0 / 8.0, 1e-12);
  EXPECT_NEAR(hypotheses[1].probability, 1.0 / 8.0, 1e-12);
}

TEST(Posterior, IsNeverSurerThanItsDoubtAllows) {
  PosteriorConfig config = Plain();
  config.doubt = 0.02;
  std::vector<Hypothesis> hypotheses{Scored("mug", 1.0)};
  SetProbabilities(config, &hypotheses);
  EXPECT_NEAR(hypotheses[0].probability, 0.98, 1e-9);
}

TEST(Posterior, DoesNotDependOnTheOrderOfTheHypotheses) {
  std::vector<Hypothesis> forth{Scored("mug", 0.99), Scored("can", 0.2, false), Scored("mug", 0.7)};
  std::vector<Hypothesis> back(forth.rbegin(), forth.rend());
  SetProbabilities(PosteriorConfig(), &forth);
  SetProbabilities(PosteriorConfig(), &back);
  for (std::size_t i = 0; i < forth.size(); ++i) {
    EXPECT_NEAR(forth[i].probability, back[forth.size() - 1 - i].probability, 1e-12);
  }
}

TEST(Posterior, FallsWhereARivalRisesAndNeverExceedsOne) {
  Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    std::vector<Hypothesis> hypotheses{Scored("mug", rng.Uniform(0, 1)),
                                       Scored("can", rng.Uniform(0, 1), rng.Index(2) == 0)};
    SetProbabilities(PosteriorConfig(), &hypotheses);
    const double before = hypotheses[0].probability;
    const double sum = before + hypotheses[1].probability;
    EXPECT_LE(sum, 1.0 - PosteriorConfig().doubt + 1e-12);
    hypotheses[1].score = 1.0 - 0.5 * (1.0 - hypotheses[1].score);
    SetProbabilities(PosteriorConfig(), &hypotheses);
    EXPECT_LT(hypotheses[0].probability, before);
  }
}

TEST(Posterior, OfAModelIsThatOfAllItsPoses) {
  std::vector<Hypothesis> hypotheses{Scored("mug", 0.5), Scored("can", 0.5), Scored("mug", 0.5)};
  SetProbabilities(Plain(), &hypotheses);
  EXPECT_NEAR(ProbabilityOf("mug", hypotheses), 0.5, 1e-12);
  EXPECT_NEAR(ProbabilityOf("can", hypotheses), 0.25, 1e-12);
  EXPECT_EQ(ProbabilityOf("bowl", hypotheses), 0.0);
}

TEST(Posterior, RefusesADoubtAboveOneAndASlopeBelowNone) {
  PosteriorConfig config;
  config.doubt = 1.5;
  EXPECT_THROWS(config.Validate(), ConfigError, "doubt = 1.5 must lie in 0..1");
  config = {};
  config.slope = -1.0;
  EXPECT_THROWS(config.Validate(), ConfigError, "slope = -1 must lie in 0..10");
}

}  // namespace
}  // namespace secondlook::perception
