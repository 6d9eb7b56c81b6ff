#include "lib/kinematics/inverse_kinematics.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::kinematics {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

class InverseKinematics : public ::testing::Test {
 protected:
  Eigen::VectorXd DrawAngles() {
    Eigen::VectorXd q(arm_.size());
    for (int i = 0; i < arm_.size(); ++i) {
      q[i] = rng_.Uniform(arm_.joint(i).lower, arm_.joint(i).upper);
    }
    return q;
  }

  Pose DrawTool() {
    Pose X_EC = Pose::Identity();
    X_EC.translation() << rng_.Uniform(-.1, .1), rng_.Uniform(-.1, .1), rng_.Uniform(0, .1);
    X_EC.linear() = RotationFromVector({rng_.Gaussian(1), rng_.Gaussian(1), rng_.Gaussian(1)});
    return X_EC;
  }

  const Chain arm_{LoadUrdf("sim/robots/arm.urdf"), "flange"};
  const Eigen::VectorXd home_{Eigen::VectorXd::Zero(7)};
  Rng rng_{21};
};

TEST_F(InverseKinematics, FindsWhatForwardKinematicsReached) {
  int solved = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose X_EC = DrawTool();
    const ToolGoal goal{arm_.TipPose(DrawAngles()) * X_EC, X_EC, false};
    const JointSolutions solutions = SolveInverseKinematics(arm_, goal, home_);
    solved += !solutions.q.empty();
    for (const Eigen::VectorXd& q : solutions.q) {
      EXPECT_TRUE(arm_.WithinLimits(q));
      const Pose X_BC = arm_.TipPose(q) * X_EC;
      EXPECT_LE((X_BC.translation() - goal.X_BC.translation()).norm(), 1e-4);
      EXPECT_LE(RotationDistance(X_BC.linear(), goal.X_BC.linear()), 0.01 * kDegree);
    }
  }
  EXPECT_GE(solved, 199);
}

TEST_F(InverseKinematics, FreeRollKeepsThePlaceAndTheDirectionOfTheAxis) {
  for (int i = 0; i < 100; ++i) {
    ToolGoal goal{arm_.TipPose(DrawAngles()), Pose::Identity(), true};
    goal.X_BC.rotate(Eigen::AngleAxisd(rng_.Uniform(-3, 3), Eigen::Vector3d::UnitZ()));
    const JointSolutions solutions = SolveInverseKinematics(arm_, goal, home_);
    ASSERT_FALSE(solutions.q.empty()) << solutions.reason;
    for (const Eigen::VectorXd& q : solutions.q) {
      const Pose X_BC = arm_.TipPose(q);
      EXPECT_LE((X_BC.translation() - goal.X_BC.translation()).norm(), 1e-4);
      EXPECT_LE(std::acos(std::min(1.0, X_BC.linear().col(2).dot(goal.X_BC.linear().col(2)))),
                0.01 * kDegree);
    }
  }
}

TEST_F(InverseKinematics, FreeRollReachesWhatAFixedRollCannot) {
  // Without joints 3, 5 and 7 the arm moves in one upright plane and cannot roll its tool at all.
  RobotModel model = arm_.model();
  for (const char* name : {"link_3", "link_5", "link_7"}) {
    model.links[model.IndexOf(name)].joint.turns = false;
  }
  const Chain stiff(model, "flange");
  Pose X_BC = stiff.TipPose(Eigen::Vector4d(0.3, 0.8, 0.9, -0.5));
  X_BC.rotate(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()));
  const Eigen::VectorXd near = Eigen::VectorXd::Zero(4);
  EXPECT_TRUE(SolveInverseKinematics(stiff, {X_BC, Pose::Identity(), false}, near).q.empty());
  EXPECT_FALSE(SolveInverseKinematics(stiff, {X_BC, Pose::Identity(), true}, near).q.empty());
}

TEST_F(InverseKinematics, SaysHowFarTheNearestIsWhereNothingReaches) {
  // Straight ahead at the height of the shoulder, which is 0.946 m from the flange at most.
  ToolGoal goal;
  goal.X_BC.translation() = Eigen::Vector3d(-0.05 + 0.946 + 0.04, -0.1, 0.70);
  goal.X_BC.linear() = RotationFromRollPitchYaw(0.0, 90.0 * kDegree, 0.0);
  const JointSolutions solutions = SolveInverseKinematics(arm_, goal, home_);
  EXPECT_TRUE(solutions.q.empty());
  EXPECT_NEAR(solutions.position_error, 0.04, 0.002);
  EXPECT_THAT(solutions.reason, ::testing::HasSubstr("unreachable: the nearest is 0.0"));
}

TEST_F(InverseKinematics, GivesTheNearestSolutionFirstAndSeveralThatDiffer) {
  const Eigen::VectorXd q = DrawAngles();
  const JointSolutions solutions =
      SolveInverseKinematics(arm_, {arm_.TipPose(q), Pose::Identity(), false}, q);
  ASSERT_GE(solutions.q.size(), 2U);
  EXPECT_LE((solutions.q.front() - q).cwiseAbs().maxCoeff(), 1e-3);
  for (std::size_t i = 1; i < solutions.q.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GE((solutions.q[i] - solutions.q[j]).cwiseAbs().maxCoeff(), 5.0 * kDegree);
    }
  }
}

TEST_F(InverseKinematics, IsTheSameEveryTime) {
  const ToolGoal goal{arm_.TipPose(DrawAngles()), Pose::Identity(), false};
  const JointSolutions first = SolveInverseKinematics(arm_, goal, home_);
  const JointSolutions second = SolveInverseKinematics(arm_, goal, home_);
  ASSERT_EQ(first.q.size(), second.q.size());
  for (std::size_t i = 0; i < first.q.size(); ++i) EXPECT_EQ(first.q[i], second.q[i]);
}

TEST_F(InverseKinematics, RefusesWhatIsNoGoal) {
  ToolGoal goal;
  goal.X_BC.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROWS(SolveInverseKinematics(arm_, goal, home_), InvalidArgument, "no rigid transform");
  EXPECT_THROWS(SolveInverseKinematics(arm_, {}, Eigen::VectorXd::Zero(3)), InvalidArgument,
                "the 3 joint angles to begin with are not 7 finite ones");
  InverseKinematicsConfig config;
  config.position_m = 0.01;
  EXPECT_THROWS(SolveInverseKinematics(arm_, {}, home_, config), ConfigError,
                "position_m = 0.01 must lie in 1e-09..0.0001");
}

}  // namespace
}  // namespace secondlook::kinematics
