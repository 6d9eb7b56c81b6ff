#include "apps/look_planner.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/experiments/sight.h"
#include "lib/common/error.h"
#include "lib/planning/choose_look.h"
#include "tests/support/expect_throws.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

/// A robot that has seen a table from one side, and nothing that it knows.
class LookPlanning : public ::testing::Test {
 protected:
  LookPlanning() {
    stance_.X_WB = {-1.5, 0.0, 0.0};
    stance_.head = {0.0, 0.35};
    Rng rng(1);
    EXPECT_EQ(known_.Add(LookFrom(stance_, &rng, &camera_).capture), "");
  }

  /// For a place behind the table's middle that nobody has seen.
  static Question Hidden(const Vector3d& size) {
    const Vector3d center(0.2, 0.0, 0.8);
    Question question;
    question.hidden_W = {{center - size / 2.0, center + size / 2.0}};
    return question;
  }

  std::vector<world::Look> Candidates(const Question& question, LookPlanner* planner) {
    Rng rng(1);
    return planner->Candidates(known_, {}, question, stance_, &rng);
  }

  static int Feasible(const std::vector<world::Look>& looks) {
    return static_cast<int>(std::count_if(looks.begin(), looks.end(),
                                          [](const world::Look& look) { return look.feasible; }));
  }

  FreeCamera camera_{sim::Scene(), 3};
  SceneUnderstanding known_{{}, {}, world::ObjectDatabase(std::vector<world::ObjectModel>{})};
  Stance stance_;
};

TEST_F(LookPlanning, OfferNoLookWhenNothingIsAsked) {
  LookPlanner planner({}, {}, CarrierOf(camera_));
  EXPECT_TRUE(Candidates({}, &planner).empty());
}

TEST_F(LookPlanning, TakesWhatHasNoSizeForSomethingThin) {
  LookPlanner planner({}, {}, CarrierOf(camera_));
  for (const world::Look& look : Candidates(Hidden(Vector3d::Zero()), &planner)) {
    EXPECT_EQ(look.kind, "hidden_space");
    EXPECT_EQ(look.way, world::LookWay::kHead);
  }
}

TEST_F(LookPlanning, RefusesATargetThatIsNowhere) {
  LookPlanner planner({}, {}, CarrierOf(camera_));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROWS(Candidates(Hidden({nan, 0.1, 0.1}), &planner), InvalidArgument, "target -1");
}

TEST_F(LookPlanning, RefusesToLookAgainFromWhereAViewTaughtNothing) {
  LookPlanner planner({}, {}, CarrierOf(camera_));
  const Question question = Hidden({0.2, 0.2, 0.1});
  std::vector<world::Look> looks = Candidates(question, &planner);
  const planning::LookChoice choice = planning::ChooseLook(&looks);
  ASSERT_TRUE(choice.index);
  planner.NoteVain(looks[*choice.index].X_WC.translation() + Vector3d(0.0, 0.03, 0.0));
  const world::Look again = Candidates(question, &planner)[*choice.index];
  EXPECT_FALSE(again.feasible);
  EXPECT_TRUE(again.reason.starts_with("not in vain: a view from (")) << again.reason;
}

TEST_F(LookPlanning, SaysWhatRefusedEveryLookOfARobotThatIsShutIn) {
  LookPlanner planner({}, {}, CarrierOf(camera_));
  for (double a = 0.0; a < 6.3; a += 0.25) {
    planner.Block({-1.5 + 0.8 * std::cos(a), 0.8 * std::sin(a)}, stance_.time);
  }
  std::vector<world::Look> looks = Candidates(Hidden({0.2, 0.2, 0.1}), &planner);
  const planning::LookChoice choice = planning::ChooseLook(&looks);
  EXPECT_FALSE(choice.index);
  EXPECT_THAT(choice.reason, ::testing::StartsWith("38 of 38 refused: "));
  EXPECT_THAT(choice.reason, ::testing::HasSubstr(" path"));
}

TEST_F(LookPlanning, ForgetsWhatClosedAWayAfterAWhile) {
  LookPlanner planner({}, {}, CarrierOf(camera_));
  const Question question = Hidden({0.2, 0.2, 0.1});
  const int open = Feasible(Candidates(question, &planner));
  ASSERT_GT(open, 0);
  stance_.time = Time(Seconds(100.0));
  for (double y = -2.0; y <= 2.0; y += 0.25) planner.Block({-1.0, y}, stance_.time);
  for (double x = -2.5; x <= -1.0; x += 0.25) {
    planner.Block({x, 2.0}, stance_.time);
    planner.Block({x, -2.0}, stance_.time);
  }
  EXPECT_LT(Feasible(Candidates(question, &planner)), open);
  stance_.time = Time(Seconds(159.0));
  EXPECT_LT(Feasible(Candidates(question, &planner)), open);
  stance_.time = Time(Seconds(160.0));
  EXPECT_EQ(Feasible(Candidates(question, &planner)), open);
}

TEST_F(LookPlanning, BeginsLooksByTheBaseWithFoldingTheArm) {
  sim::SimConfig config;
  config.arm.emplace().urdf = "sim/robots/arm.urdf";
  const sim::SimulatedRobot simulated = sim::MakeSimulatedRobot(sim::Scene(), config, 3);
  const hal::Robot& robot = simulated.robot;
  stance_.q = robot.arm->State().q;
  LookPlanner planner({}, {}, CarrierOf(camera_));
  const Question question = Hidden({0.2, 0.2, 0.1});
  const std::vector<world::Look> without = Candidates(question, &planner);
  planner.KnowArm(
      {{},
       {robot.base->info(), robot.arm->info(), robot.hand_camera->info(), *simulated.hand},
       stance_.q,
       1});
  const std::vector<world::Look> folded = Candidates(question, &planner);
  EXPECT_GT(folded.size(), without.size());
  for (std::size_t i = 0; i < folded.size(); ++i) {
    const bool by_arm = folded[i].way == world::LookWay::kArm;
    EXPECT_EQ(by_arm, i >= without.size());
    if (!by_arm) {
      EXPECT_TRUE(folded[i].arm_motion.knots.empty());
    }
  }

  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(7);
  const Eigen::VectorXd home = stance_.q;
  stance_.q[0] += 0.5;
  planner.NoteArm({{{0.0, home, rest}, {2.0, stance_.q, rest}}}, stance_.q);
  const std::vector<world::Look> stretched = Candidates(question, &planner);
  for (std::size_t i = 0; i < without.size(); ++i) {
    const hal::JointTrajectory& fold = stretched[i].arm_motion;
    ASSERT_FALSE(fold.knots.empty());
    EXPECT_EQ(fold.knots.front().q, stance_.q);
    EXPECT_LT((fold.knots.back().q - home).norm(), 0.02);
    EXPECT_NEAR(stretched[i].seconds, without[i].seconds + fold.seconds(), 1e-9);
  }
}

}  // namespace
}  // namespace secondlook::apps
