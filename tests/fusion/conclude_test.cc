#include "lib/fusion/conclude.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::fusion {
namespace {

using world::ObjectBelief;
using world::ObjectState;
using world::PoseHypothesis;

world::ViewEvidence View(int view, double score, double visible_fraction = 0.8) {
  world::ViewEvidence e;
  e.view = view;
  e.hypothesis.score = score;
  e.hypothesis.verification.visible = static_cast<int>(1000 * visible_fraction);
  e.hypothesis.verification.visible_fraction = visible_fraction;
  e.hypothesis.verification.color_agreement = 0.9;
  e.hypothesis.verification.accepted = score > 0.5;
  e.hypothesis.verification.reason = score > 0.5 ? "" : "see-through 40 %";
  return e;
}

PoseHypothesis Hypothesis(const std::string& model, double yaw,
                          std::vector<world::ViewEvidence> evidence) {
  PoseHypothesis h;
  h.model = model;
  h.X_WM = ToPose(Pose2{0, 0, yaw});
  h.evidence = std::move(evidence);
  return h;
}

ObjectBelief Object(std::vector<PoseHypothesis> hypotheses, int clear_views) {
  ObjectBelief object;
  object.hypotheses = std::move(hypotheses);
  Conclude(world::Task{}, {}, clear_views, &object);
  return object;
}

TEST(Conclude, VerifiesWhatOneViewIsSureOf) {
  const ObjectBelief object = Object({Hypothesis("mug", 0, {View(0, 0.97)})}, 1);
  EXPECT_EQ(object.state, ObjectState::kVerified) << object.reason;
  EXPECT_EQ(object.Best()->model, "mug");
}

TEST(Conclude, AsksForAnotherLookWhereTheColoursAgreePoorly) {
  PoseHypothesis mug = Hypothesis("mug", 0, {View(0, 0.97)});
  mug.evidence[0].hypothesis.verification.color_agreement = 0.7;
  const ObjectBelief object = Object({mug}, 1);
  EXPECT_EQ(object.state, ObjectState::kCandidate);
  EXPECT_THAT(object.reason, testing::HasSubstr("its colours agree by 0.70 (at least 0.78)"));
  // A camera without colour is not asked for it.
  mug.evidence[0].hypothesis.verification.color_agreement =
      std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Object({mug}, 1).state, ObjectState::kVerified);
}

TEST(Conclude, LeavesLookAlikesOpenAndSaysWhichTwo) {
  const ObjectBelief object =
      Object({Hypothesis("rice", 0, {View(0, 0.95)}), Hypothesis("oat", 0, {View(0, 0.94)})}, 1);
  EXPECT_EQ(object.state, ObjectState::kCandidate);
  EXPECT_THAT(object.reason, testing::HasSubstr("several hypotheses: 'rice'"));
}

TEST(Conclude, IsSettledByTheViewThatTellsLookAlikesApart) {
  const ObjectBelief object = Object({Hypothesis("rice", 0, {View(0, 0.95), View(1, 0.02)}),
                                      Hypothesis("oat", 0, {View(0, 0.94), View(1, 0.96)})},
                                     2);
  EXPECT_EQ(object.state, ObjectState::kVerified) << object.reason;
  EXPECT_EQ(object.Best()->model, "oat");
  EXPECT_TRUE(object.hypotheses.back().struck);
  EXPECT_EQ(object.hypotheses.back().reason, "view 1 contradicts it: see-through 40 %");
}

TEST(Conclude, StrikesWhatTheMapKnowsToBeFree) {
  PoseHypothesis mug = Hypothesis("mug", 0, {View(0, 0.97)});
  mug.likely_free = 0.32;
  EXPECT_EQ(Object({mug}, 1).state, ObjectState::kVerified);
  mug.likely_free = 0.41;
  const ObjectBelief object = Object({mug}, 1);
  EXPECT_EQ(object.state, ObjectState::kCandidate);
  EXPECT_EQ(object.Best(), nullptr);
  EXPECT_EQ(object.hypotheses.front().reason,
            "the map contradicts it: 41 % of it lies in likely free space");
}

TEST(ConcludeConfig, NamesTheValueThatIsOutOfRange) {
  EXPECT_NO_THROW(ConcludeConfig().Validate());
  ConcludeConfig config;
  config.view_reliability = 1.2;
  EXPECT_THROWS(config.Validate(), ConfigError, "view_reliability = 1.2 must be between 0 and 1");
  config = {};
  config.max_likely_free = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROWS(config.Validate(), ConfigError, "max_likely_free = nan");
}

TEST(Conclude, LeavesAPoseOpenThatHasARival) {
  const ObjectBelief object =
      Object({Hypothesis("mug", 0, {View(0, 0.95)}), Hypothesis("mug", 1, {View(0, 0.9)})}, 1);
  EXPECT_EQ(object.state, ObjectState::kCandidate);
  EXPECT_THAT(object.reason, testing::HasSubstr("its pose is open: two differ by 57 deg"));
}

TEST(Conclude, AsksForLessOfALeadOverAPoseThatIsNearlyTheSame) {
  // Log-odds 3.66 and 1.39: the lead is 2.3.
  const auto object = [](double yaw_deg) {
    return Object({Hypothesis("mug", 0, {View(0, 0.975)}),
                   Hypothesis("mug", yaw_deg * 0.0174533, {View(0, 0.8)})},
                  1);
  };
  EXPECT_EQ(object(7).state, ObjectState::kVerified) << object(7).reason;
  EXPECT_EQ(object(70).state, ObjectState::kCandidate);
}

TEST(Conclude, DoesNotVerifyWhatTheLargerViewRejects) {
  PoseHypothesis mug = Hypothesis("mug", 0, {View(0, 0.999), View(1, 0.999)});
  mug.evidence[1].hypothesis.verification.accepted = false;
  mug.evidence[1].hypothesis.verification.reason = "the camera sees through 20 % of it";
  const ObjectBelief object = Object({mug}, 2);
  EXPECT_EQ(object.state, ObjectState::kCandidate);
  EXPECT_THAT(object.reason, testing::HasSubstr("view 1: the camera sees through 20 % of it"));
  mug.evidence[1].hypothesis.verification.visible = 100;  // of 900
  EXPECT_EQ(Object({mug}, 2).state, ObjectState::kVerified);
}

TEST(Conclude, CallsUnknownOnlyAfterEnoughClearViews) {
  const std::vector<PoseHypothesis> hypotheses{
      Hypothesis("mug", 0, {View(0, 0.2, 0.3), View(1, 0.2, 0.3)})};
  EXPECT_EQ(Object(hypotheses, 1).state, ObjectState::kCandidate);
  const ObjectBelief object = Object(hypotheses, 2);
  EXPECT_EQ(object.state, ObjectState::kUnknown);
  EXPECT_THAT(object.reason, testing::HasSubstr("the nearest model is 'mug' with support 0.20"));
  EXPECT_THAT(Object({}, 2).reason, testing::HasSubstr("no model in the database fits"));
}

TEST(Conclude, CallsUnknownWhatOneMoreClearViewAcceptsAtNoPose) {
  // Support of 0.3 in each of three views would add up to 1 - 0.7^3 = 0.66.
  const auto whisk = [](int views, int accepting) {
    std::vector<world::ViewEvidence> evidence;
    for (int i = 0; i < views; ++i) evidence.push_back(View(i, i < accepting ? 0.7 : 0.3));
    return Object({Hypothesis("whisk", 0, evidence)}, views);
  };
  EXPECT_EQ(whisk(2, 0).state, ObjectState::kCandidate);
  EXPECT_EQ(whisk(3, 0).state, ObjectState::kUnknown);
  EXPECT_THAT(whisk(3, 0).reason, testing::HasSubstr("the nearest model is 'whisk'"));
  EXPECT_EQ(whisk(3, 1).state, ObjectState::kCandidate);
}

TEST(Conclude, DoesNotStrikeAHypothesisThatIsHidden) {
  const ObjectBelief object =
      Object({Hypothesis("mug", 0, {View(0, 0.97), View(1, 0.05, 0.1)})}, 1);
  EXPECT_FALSE(object.hypotheses.front().struck);
  EXPECT_EQ(object.state, ObjectState::kVerified) << object.reason;
}

TEST(Conclude, DoesNotStrikeForOneViewWhatNineOthersHold) {
  std::vector<world::ViewEvidence> views;
  for (int i = 0; i < 9; ++i) views.push_back(View(i, 0.97));
  views.push_back(View(9, 0.02));  // 9 of 10 pixels are in views that accept it
  const ObjectBelief held = Object({Hypothesis("mug", 0, views)}, 3);
  EXPECT_FALSE(held.hypotheses.front().struck);
  EXPECT_EQ(held.state, ObjectState::kVerified) << held.reason;
  views.pop_back();
  views.back() = View(8, 0.02);  // 8 of 9
  EXPECT_TRUE(Object({Hypothesis("mug", 0, views)}, 3).hypotheses.front().struck);
}

TEST(Lead, OfAPoseThatASmallViewJustAcceptsOverOneThatItJustDoesNotIsNone) {
  const auto odds = [](double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); };
  PoseHypothesis accepted = Hypothesis("mug", 0, {View(0, odds(5.0), 0.2)});  // 200 pixels
  PoseHypothesis refused = Hypothesis("mug", 0, {View(0, odds(3.0), 0.2)});   // less 2, as 199 fail
  refused.evidence[0].hypothesis.verification.accepted = false;
  EXPECT_NEAR(Lead({}, accepted, refused), 0.0, 1e-9);
  // In a view that sees enough, a refusal counts: as log-odds of at most those of 0.3.
  accepted.evidence[0].hypothesis.verification.visible = 800;
  refused.evidence[0].hypothesis.verification.visible = 800;
  EXPECT_NEAR(Lead({}, accepted, refused), 5.0 - std::log(3.0 / 7.0), 1e-9);
}

TEST(Conclude, HoldsAWantedClassToItsOwnConfidence) {
  world::Task task;
  task.wanted["medicine"] = 0.99;
  ObjectBelief object;
  object.hypotheses = {Hypothesis("medicine", 0, {View(0, 0.95)})};
  Conclude(task, {}, 1, &object);
  EXPECT_EQ(object.state, ObjectState::kCandidate);
  EXPECT_THAT(object.reason, testing::HasSubstr("needs 0.99"));
  object.hypotheses = {Hypothesis("medicine", 0, {View(0, 0.95), View(1, 0.95)})};
  Conclude(task, {}, 2, &object);
  EXPECT_EQ(object.state, ObjectState::kVerified) << object.reason;
}

TEST(Conclude, DoesNotDependOnTheOrderOfTheViews) {
  const auto hypotheses = [](bool turned) {
    std::vector<world::ViewEvidence> a{View(0, 0.9), View(1, 0.4), View(2, 0.7)};
    std::vector<world::ViewEvidence> b{View(0, 0.3), View(1, 0.6), View(2, 0.2)};
    if (turned) {
      std::reverse(a.begin(), a.end());
      std::reverse(b.begin(), b.end());
    }
    return std::vector<PoseHypothesis>{Hypothesis("a", 0, a), Hypothesis("b", 0, b)};
  };
  const ObjectBelief forward = Object(hypotheses(false), 3);
  const ObjectBelief backward = Object(hypotheses(true), 3);
  EXPECT_EQ(forward.state, backward.state);
  EXPECT_NEAR(forward.masses.Of("a"), backward.masses.Of("a"), 1e-12);
  EXPECT_NEAR(forward.masses.conflict, backward.masses.conflict, 1e-12);
}

/// What pictures say: each class's mass, the rest of 1 is m(Omega).
Appearance Pictures(const std::map<std::string, double>& masses,
                    const std::set<std::string>& without_model = {}) {
  Appearance appearance;
  appearance.masses.singletons = masses;
  for (const auto& [c, mass] : masses) appearance.masses.omega -= mass;
  appearance.without_model = without_model;
  return appearance;
}

ObjectBelief Object(std::vector<PoseHypothesis> hypotheses, int clear_views,
                    const Appearance& appearance) {
  ObjectBelief object;
  object.hypotheses = std::move(hypotheses);
  Conclude(world::Task{}, {}, clear_views, appearance, &object);
  return object;
}

TEST(ConcludeByLooks, LetsThePrintSettleWhatFitsTwoModelsAlike) {
  const std::vector<PoseHypothesis> alike{Hypothesis("rice", 0, {View(0, 0.95)}),
                                          Hypothesis("oat", 0, {View(0, 0.95)})};
  ASSERT_EQ(Object(alike, 1).state, ObjectState::kCandidate);
  // By shape m(rice) = m(oat) = 0.97 * 19 / 39 = 0.4726 and m(Omega) = 0.0549. With the print
  // m(rice) = 0.4726 * 0.98 + 0.0549 * 0.92 = 0.5136, m(oat) = 0.4726 * 0.08 + 0.0549 * 0.02 =
  // 0.0389 and m(Omega) = 0.0549 * 0.06 = 0.0033: of them, rice has 0.924.
  const ObjectBelief object = Object(alike, 1, Pictures({{"rice", 0.92}, {"oat", 0.02}}));
  EXPECT_EQ(object.state, ObjectState::kVerified) << object.reason;
  EXPECT_EQ(object.Best()->model, "rice");
  EXPECT_THAT(object.reason, testing::HasSubstr("'rice' at 0.924"));
}

TEST(ConcludeByLooks, IsNotTalkedIntoAModelThatDoesNotFit) {
  const Appearance like_a_mug = Pictures({{"mug", 0.95}, {"oat", 0.03}});
  const ObjectBelief once = Object({}, 1, like_a_mug);
  EXPECT_EQ(once.state, ObjectState::kCandidate);
  EXPECT_EQ(once.reason, "looks like 'mug' at 0.95, but its model fits nowhere");
  // By now it should have fitted: what the pictures say is conflict, the sign of a new object.
  const ObjectBelief twice = Object({}, 2, like_a_mug);
  EXPECT_EQ(twice.state, ObjectState::kUnknown);
  EXPECT_NEAR(twice.masses.conflict, 0.98, 1e-12);
  EXPECT_NEAR(twice.masses.omega, 0.02, 1e-12);
}

TEST(ConcludeByLooks, StaysOpenWhereShapeAndPrintContradictEachOther) {
  const ObjectBelief object =
      Object({Hypothesis("mug", 0, {View(0, 0.97)})}, 1, Pictures({{"mug", 0.02}, {"oat", 0.9}}));
  EXPECT_EQ(object.state, ObjectState::kCandidate) << object.reason;
  EXPECT_GT(object.masses.conflict, 0.8);
}

TEST(ConcludeByLooks, KnowsByItsClassAloneWhatHasNoModel) {
  const Appearance like_a_duck = Pictures({{"duck", 0.93}, {"mug", 0.02}}, {"duck"});
  EXPECT_EQ(Object({}, 1, like_a_duck).reason,
            "looks like 'duck' at 0.93, of which there is no model; needs 0.90 from 2 sides");
  const ObjectBelief duck = Object({}, 2, like_a_duck);
  EXPECT_EQ(duck.state, ObjectState::kClassified);
  EXPECT_EQ(duck.LeadingClass(), "duck");
  EXPECT_EQ(duck.Best(), nullptr);
  EXPECT_TRUE(duck.Settled());
  // A picture that is less sure leaves it open, one that says next to nothing unknown.
  EXPECT_EQ(Object({}, 2, Pictures({{"duck", 0.7}, {"mug", 0.1}}, {"duck"})).state,
            ObjectState::kCandidate);
  EXPECT_EQ(Object({}, 2, Pictures({{"duck", 0.2}, {"mug", 0.4}}, {"duck"})).state,
            ObjectState::kUnknown);
}

TEST(ConcludeByLooks, LeavesToShapeWhatPicturesDoNotTellOf) {
  const std::vector<PoseHypothesis> fits{Hypothesis("gear", 0, {View(0, 0.97)})};
  const ObjectBelief object = Object(fits, 1, Pictures({{"mug", 0.9}, {"oat", 0.05}}));
  EXPECT_EQ(object.state, ObjectState::kVerified) << object.reason;
  EXPECT_EQ(object.masses.singletons, Object(fits, 1).masses.singletons);
}

}  // namespace
}  // namespace secondlook::fusion
