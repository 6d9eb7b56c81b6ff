#include "apps/guiding_hypotheses.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/world/task.h"

namespace secondlook::apps {
namespace {

world::PoseHypothesis Hypothesis(const std::string& model, double yaw, double score) {
  world::PoseHypothesis h;
  h.model = model;
  h.X_WM = ToPose(Pose2{0.0, 0.0, yaw});
  world::ViewEvidence e;
  e.hypothesis.score = score;
  e.hypothesis.verification.visible = 800;
  e.hypothesis.verification.visible_fraction = 0.8;
  e.hypothesis.verification.color_agreement = 0.9;
  e.hypothesis.verification.accepted = score > 0.5;
  h.evidence.push_back(e);
  return h;
}

/// What one view told of.
world::ObjectBelief Object(std::vector<world::PoseHypothesis> hypotheses) {
  world::ObjectBelief object;
  object.hypotheses = std::move(hypotheses);
  object.sightings.push_back({});
  fusion::Conclude(world::Task{}, {}, 1, &object);
  return object;
}

TEST(GuidingHypotheses, AreNoneWhereNoModelFits) {
  const fusion::ConcludeConfig config;
  EXPECT_TRUE(LikelyHypotheses(Object({}), config).empty());
  const world::ObjectBelief object = Object({Hypothesis("mug", 0.0, 0.12)});
  ASSERT_NE(object.Best(), nullptr);
  EXPECT_TRUE(LikelyHypotheses(object, config).empty());
  EXPECT_TRUE(Rivals(object, {}, config).empty());
}

TEST(GuidingHypotheses, ShareTheBeliefInAClassByTheLeadsOfItsPoses) {
  const fusion::ConcludeConfig config;
  const world::ObjectBelief object =
      Object({Hypothesis("mug", 0.0, 0.9), Hypothesis("mug", 1.0, 0.75)});
  const std::vector<GuidingHypothesis> likely = LikelyHypotheses(object, config);
  ASSERT_EQ(likely.size(), 2U);
  // Odds of 9 to 1 and 3 to 1, in a class that 0.97 * 0.9 is believed of.
  EXPECT_NEAR(likely[0].probability, 0.873 * 0.75, 1e-9);
  EXPECT_NEAR(likely[1].probability, 0.873 * 0.25, 1e-9);
}

TEST(GuidingHypotheses, NeedTheLeadOverOtherPosesThatConcludingAsksFor) {
  fusion::ConcludeConfig config;
  config.min_lead = 3.0;
  config.min_near_lead = 2.0;
  world::Task task;
  task.confidence = 0.9;
  const auto needed = [&](const world::PoseHypothesis& other) {
    const world::ObjectBelief object = Object({Hypothesis("mug", 0.0, 0.95), other});
    return NeededProbability(object.hypotheses.front(), object, task, config);
  };
  EXPECT_DOUBLE_EQ(needed(Hypothesis("jug", 1.0, 0.9)), 0.9);
  EXPECT_DOUBLE_EQ(needed(Hypothesis("mug", 1.0, 0.9)), 1.0 / (1.0 + std::exp(-3.0)));
  EXPECT_DOUBLE_EQ(needed(Hypothesis("mug", 0.1, 0.9)), 0.9);  // near: e^2 to 1 is less than that
}

TEST(GuidingHypotheses, HoldWhatAViewStruckForPossibleAsFarAsItMayMislead) {
  fusion::ConcludeConfig config;
  config.view_reliability = 0.97;
  world::ObjectBelief object = Object(
      {Hypothesis("mug", 0.0, 0.99), Hypothesis("jug", 0.0, 0.02), Hypothesis("mug", 1.0, 0.01)});
  ASSERT_TRUE(object.hypotheses[1].struck);
  const std::vector<GuidingHypothesis> likely = LikelyHypotheses(object, config);
  ASSERT_EQ(likely.size(), 1U);
  std::vector<GuidingHypothesis> rivals = Rivals(object, likely, config);
  ASSERT_EQ(rivals.size(), 2U);
  EXPECT_EQ(rivals[0].hypothesis->model, "jug");
  EXPECT_EQ(rivals[1].hypothesis->model, "mug");
  // 0.03, shared by the two and what is none of the three.
  EXPECT_NEAR(rivals[0].probability, 0.01, 1e-12);
  EXPECT_NEAR(rivals[1].probability, 0.01, 1e-12);
  object.sightings.push_back({});  // another view that says the same
  rivals = Rivals(object, likely, config);
  EXPECT_NEAR(rivals[0].probability, 0.0003, 1e-12);
}

TEST(GuidingHypotheses, AreFourAtMost) {
  const fusion::ConcludeConfig config;
  std::vector<world::PoseHypothesis> many;
  for (int i = 0; i < 6; ++i) many.push_back(Hypothesis("mug", i, i == 0 ? 0.99 : 0.03));
  const world::ObjectBelief object = Object(many);
  const std::vector<GuidingHypothesis> likely = LikelyHypotheses(object, config);
  EXPECT_EQ(likely.size() + Rivals(object, likely, config).size(), 4U);
}

}  // namespace
}  // namespace secondlook::apps
