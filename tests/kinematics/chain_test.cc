#include "lib/kinematics/chain.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::kinematics {
namespace {

Chain SimulatedArm() { return Chain(LoadUrdf("sim/robots/arm.urdf"), "flange"); }

Eigen::VectorXd DrawAngles(const Chain& chain, Rng* rng) {
  Eigen::VectorXd q(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    q[i] = rng->Uniform(chain.joint(i).lower, chain.joint(i).upper);
  }
  return q;
}

/// A chain of random joints, every third of them fixed.
Chain DrawChain(Rng* rng) {
  const auto draw = [&] {
    return fmt::format("{} {} {}", rng->Uniform(-1, 1), rng->Uniform(-1, 1), rng->Uniform(-1, 1));
  };
  std::string urdf = R"(<robot name="random"><link name="link_0"/>)";
  for (int i = 1; i <= 9; ++i) {
    urdf += fmt::format(
        R"(<link name="link_{}"/><joint name="joint_{}" type="{}"><parent link="link_{}"/>
           <child link="link_{}"/><origin xyz="{}" rpy="{}"/><axis xyz="{}"/>
           <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>)",
        i, i, i % 3 == 0 ? "fixed" : "revolute", i - 1, i, draw(), draw(), draw());
  }
  return Chain(ParseUrdf(urdf + "</robot>", "random"), "link_9");
}

TEST(Chain, HasTheJointsOnTheWayToItsTip) {
  const Chain arm = SimulatedArm();
  ASSERT_EQ(arm.size(), 7);
  EXPECT_EQ(arm.joint(0).name, "joint_1");
  EXPECT_EQ(arm.joint(6).name, "joint_7");
  EXPECT_EQ(arm.model().links[arm.link_of(3)].name, "link_4");
}

TEST(Chain, StandsUprightAtZeroAsTallAsTheDataSheetSays) {
  // 0.36 + 0.42 + 0.40 + 0.126 m above its mount.
  const Pose X_BE = SimulatedArm().TipPose(Eigen::VectorXd::Zero(7));
  EXPECT_TRUE(X_BE.translation().isApprox(Eigen::Vector3d(-0.05, -0.1, 0.34 + 1.306), 1e-9));
  EXPECT_TRUE(X_BE.linear().isIdentity(1e-9));
}

TEST(Chain, BendsItsElbowForwardByTheSecondJoint) {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(7);
  q[1] = std::numbers::pi / 2;
  // Stretched out along x at the height of the shoulder.
  EXPECT_TRUE(SimulatedArm().TipPose(q).translation().isApprox(
      Eigen::Vector3d(-0.05 + 0.42 + 0.40 + 0.126, -0.1, 0.34 + 0.36), 1e-9));
}

TEST(Chain, TipPoseIsTheProductOfTheTransformsOfItsJoints) {
  Rng rng(11);
  for (int i = 0; i < 100; ++i) {
    const Chain chain = i < 50 ? DrawChain(&rng) : SimulatedArm();
    const Eigen::VectorXd q = DrawAngles(chain, &rng);
    Eigen::Matrix4d product = Eigen::Matrix4d::Identity();
    int turned = 0;
    for (const Link& link : chain.model().links) {
      if (link.parent < 0 || link.name == "hand_camera") continue;
      product *= link.joint.X_PL.matrix();
      if (!link.joint.turns) continue;
      // Rodrigues' formula.
      const Eigen::Vector3d a = link.joint.axis_L;
      Eigen::Matrix3d cross;
      cross << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
      Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
      turn.topLeftCorner<3, 3>() +=
          std::sin(q[turned]) * cross + (1.0 - std::cos(q[turned])) * cross * cross;
      product *= turn;
      ++turned;
    }
    EXPECT_TRUE(chain.TipPose(q).matrix().isApprox(product, 1e-9)) << i;
    const int tip = chain.model().IndexOf(i < 50 ? "link_9" : "flange");
    EXPECT_TRUE(chain.LinkPoses(q)[tip].matrix().isApprox(product, 1e-9)) << i;
  }
}

TEST(Chain, JacobianIsTheDifferenceOfPoses) {
  Rng rng(12);
  const double step = 1e-6;
  for (int i = 0; i < 100; ++i) {
    const Chain chain = i < 50 ? DrawChain(&rng) : SimulatedArm();
    const Eigen::VectorXd q = DrawAngles(chain, &rng);
    const auto jacobian = chain.Jacobian(q);
    for (int j = 0; j < chain.size(); ++j) {
      const Eigen::VectorXd dq = step * Eigen::VectorXd::Unit(chain.size(), j);
      const Pose before = chain.TipPose(q - dq);
      const Pose after = chain.TipPose(q + dq);
      const Eigen::Vector3d v = (after.translation() - before.translation()) / (2.0 * step);
      const Eigen::AngleAxisd turn(after.linear() * before.linear().transpose());
      const Eigen::Vector3d w = turn.angle() * turn.axis() / (2.0 * step);
      EXPECT_TRUE(jacobian.col(j).head<3>().isApprox(v, 1e-5) ||
                  (jacobian.col(j).head<3>() - v).norm() < 1e-5);
      EXPECT_TRUE(jacobian.col(j).tail<3>().isApprox(w, 1e-5));
    }
  }
}

TEST(Chain, BodyMovesWithItsLinks) {
  const Chain arm = SimulatedArm();
  const auto straight = arm.Body(Eigen::VectorXd::Zero(7));
  Eigen::VectorXd q = Eigen::VectorXd::Zero(7);
  q[6] = 1.0;  // only the last link and the camera on it turn
  const auto turned = arm.Body(q);
  ASSERT_EQ(straight.size(), turned.size());
  EXPECT_TRUE(straight.front().X_AS.isApprox(turned.front().X_AS));
  EXPECT_FALSE(straight.back().X_AS.isApprox(turned.back().X_AS));
}

TEST(Chain, RefusesATipThatIsNoneOrStandsStill) {
  const RobotModel model = LoadUrdf("sim/robots/arm.urdf");
  EXPECT_THROWS(Chain(model, "gripper"), ConfigError, "has no link 'gripper'");
  EXPECT_THROWS(Chain(model, "arm_base"), ConfigError,
                "no joint between its root 'base' and the tip 'arm_base'");
}

}  // namespace
}  // namespace secondlook::kinematics
