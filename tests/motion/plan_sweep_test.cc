#include "lib/planning/motion/plan_sweep.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/motion/arm_rig.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector3d;

const Eigen::VectorXd kStart = Degrees({0, 60, 0, -40, 0, 40, 0});

hal::StriperInfo Striper() { return {"striper", 640, 0.2487, 0.3, 0.6, 50.0, 0.0001}; }

/// An arm at the origin of W that carries a laser beside its flange.
struct Rig {
  kinematics::Chain arm = SimulatedArm();
  LaserCarrier carrier{JointsOf(arm, 2.5), Pose::Identity(), Pose::Identity(), kStart};

  Rig() { carrier.X_EL.translation() = Vector3d(-0.06, 0.0, 0.03); }

  PlannedSweep Plan(const SweepGoal& goal, const world::VoxelSpace& space,
                    const SweepConfig& config = {}) const {
    const ArmCollision collision(
        arm, Pose::Identity(),
        ObstaclesAround({-0.05, -0.1, 0.7}, ReachOf(arm), space, {}, arm.Body(kStart), {}));
    return PlanSweep(goal, carrier, collision, 1, config);
  }
};

/// From above the robot, along y, over a point before it.
SweepGoal FromAbove(double length_m = 0.2) {
  return SweepOver({0.75, 0.0, 0.75}, {0.7, 0.0, -0.7}, Vector3d::UnitY(), length_m, Striper());
}

TEST(SweepOver, FacesItsTargetFromTheMiddleOfTheRange) {
  const SweepGoal goal =
      SweepOver({1.0, 2.0, 3.0}, {0.0, -2.0, 0.0}, {3.0, 1.0, 0.0}, 0.2, Striper());
  EXPECT_TRUE(goal.X_WL.translation().isApprox(Vector3d(1.0, 2.45, 3.0)));
  EXPECT_TRUE(goal.X_WL.linear().col(2).isApprox(-Vector3d::UnitY()));
  EXPECT_TRUE(goal.X_WL.linear().col(1).isApprox(Vector3d::UnitX()));
  EXPECT_NEAR(goal.X_WL.linear().determinant(), 1.0, 1e-12);
  EXPECT_THROWS(SweepOver({0, 0, 0}, {0, 1, 0}, {0, -2, 0}, 0.2, Striper()), InvalidArgument,
                "not parallel");
}

TEST(PlanSweep, GoesStraightAtAConstantSpeedWithoutTurning) {
  const Rig rig;
  const SweepGoal goal = FromAbove();
  const PlannedSweep plan = rig.Plan(goal, FreeSpace());
  ASSERT_EQ(plan.outcome, SweepOutcome::kFound) << plan.reason;
  EXPECT_NEAR(plan.sweep.seconds(), 0.2 / 0.04 + 0.2, 1e-9);
  EXPECT_LT((plan.approach.knots.front().q - kStart).norm(), 1e-12);
  EXPECT_LT((plan.approach.knots.back().q - plan.sweep.knots.front().q).norm(), 1e-12);
  hal::CheckTrajectory(plan.sweep, "arm", rig.carrier.joints, plan.sweep.knots.front().q);

  const auto laser = [&](double t) -> Pose {
    return rig.arm.TipPose(hal::Sample(plan.sweep, t).q) * rig.carrier.X_EL;
  };
  const double end = plan.sweep.seconds();
  EXPECT_NEAR((laser(0.0).translation() - laser(end).translation()).norm(), 0.2, 1e-6);
  for (double t = 0.0; t < end; t += 0.013) {
    const Pose X_GL = goal.X_WL.inverse() * laser(t);
    EXPECT_LE(X_GL.translation().cwiseProduct(Vector3d(1, 0, 1)).norm(), 0.0003) << t;
    EXPECT_LE(std::abs(X_GL.translation().y()), 0.1003) << t;
    EXPECT_NEAR(X_GL.linear()(2, 2), 1.0, 1e-6) << t;
    EXPECT_NEAR(std::abs(X_GL.linear()(0, 0)), 1.0, 1e-6) << t;  // the fan, either way round
    if (t < 0.2 || t > end - 0.3) continue;
    EXPECT_NEAR((laser(t + 0.05).translation() - laser(t).translation()).norm(), 0.002, 2e-4) << t;
  }
}

TEST(PlanSweep, RefusesWhatIsTooLongAndSaysHowLong) {
  const Rig rig;
  const PlannedSweep plan = rig.Plan(FromAbove(0.31), FreeSpace());
  EXPECT_EQ(plan.outcome, SweepOutcome::kTooLong);
  EXPECT_THAT(plan.reason, ::testing::HasSubstr("a sweep of 0.310 m takes 8.0 s; at most 0.300 m"));
  SweepConfig slow;
  slow.speed_m_s = 0.015;
  EXPECT_EQ(rig.Plan(FromAbove(0.2), FreeSpace(), slow).outcome, SweepOutcome::kTooLong);
  EXPECT_TRUE(plan.sweep.knots.empty());
}

TEST(PlanSweep, RefusesWhatTheArmCannotReach) {
  const Rig rig;
  const SweepGoal far =
      SweepOver({2.0, 0.0, 0.75}, {0.7, 0.0, -0.7}, Vector3d::UnitY(), 0.2, Striper());
  const PlannedSweep plan = rig.Plan(far, FreeSpace());
  EXPECT_EQ(plan.outcome, SweepOutcome::kUnreachable);
  EXPECT_THAT(plan.reason, ::testing::HasSubstr("unreachable"));
}

TEST(PlanSweep, RefusesASweepIntoSomethingAndNamesIt) {
  const Rig rig;
  world::VoxelSpace space = FreeSpace();
  // A post where the hand would pass, and nowhere near it at either end.
  Occupy({Vector3d(0.3, -0.03, 1.0), Vector3d(0.5, 0.03, 1.6)}, &space);
  const PlannedSweep plan = rig.Plan(FromAbove(0.3), space);
  EXPECT_NE(plan.outcome, SweepOutcome::kFound);
  EXPECT_EQ(plan.outcome, SweepOutcome::kInCollision) << plan.reason;
  EXPECT_THAT(plan.reason, ::testing::HasSubstr("m along the sweep the arm touches something"));
}

TEST(PlanSweep, IsTheSameEveryTime) {
  const Rig rig;
  const PlannedSweep a = rig.Plan(FromAbove(), FreeSpace());
  const PlannedSweep b = rig.Plan(FromAbove(), FreeSpace());
  ASSERT_EQ(a.sweep.knots.size(), b.sweep.knots.size());
  for (std::size_t k = 0; k < a.sweep.knots.size(); ++k) {
    EXPECT_EQ(a.sweep.knots[k].q, b.sweep.knots[k].q);
  }
}

TEST(PlanSweep, RefusesAGoalOrAConfigurationThatIsNone) {
  const Rig rig;
  SweepGoal goal = FromAbove();
  goal.length_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROWS(rig.Plan(goal, FreeSpace()), InvalidArgument, "its length, nan m, at least the");
  SweepConfig config;
  config.speed_m_s = 0.0;
  EXPECT_THROWS(config.Validate(), ConfigError, "speed_m_s = 0 must lie in 0.001..1");
}

}  // namespace
}  // namespace secondlook::planning
