#include "lib/kinematics/robot_model.h"

#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::kinematics {
namespace {

constexpr const char* kLinks = R"(<link name="base"/><link name="upper"/><link name="lower"/>)";
constexpr const char* kShoulder = R"(
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.5"/><axis xyz="0 0 2"/>
    <limit lower="-1" upper="2" velocity="1.5" effort="1"/></joint>)";
constexpr const char* kElbow = R"(
  <joint name="elbow" type="fixed"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.3 0 0" rpy="0 0 1.5707963267948966"/></joint>)";

RobotModel Parse(const std::string& inside) {
  return ParseUrdf("<robot name=\"toy\">" + inside + "</robot>", "toy.urdf");
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

/// Expects the toy robot with `from` replaced by `to` in its shoulder to be refused.
void ExpectShoulderRefused(const std::string& from, const std::string& to,
                           const std::string& text) {
  const std::string robot = kLinks + Replaced(kShoulder, from, to) + kElbow;
  EXPECT_THROWS(Parse(robot), ConfigError, text);
  EXPECT_THROWS(Parse(robot), ConfigError, "toy.urdf");
}

TEST(ParseUrdf, ReadsLinksJointsLimitsAndBodies) {
  const RobotModel model =
      Parse(std::string(R"(<link name="base"><collision><origin xyz="0 0 1" rpy="0 0 0"/><geometry>
        <cylinder radius="0.1" length="0.4"/></geometry></collision></link>
        <link name="upper"/><link name="lower"/>)") +
            kShoulder + kElbow);
  ASSERT_EQ(model.links.size(), 3U);
  EXPECT_EQ(model.links[0].name, "base");
  EXPECT_EQ(model.links[1].parent, 0);
  EXPECT_EQ(model.links[2].parent, 1);
  EXPECT_FALSE(model.links[2].joint.turns);
  const Joint& shoulder = model.links[1].joint;
  EXPECT_TRUE(shoulder.turns);
  EXPECT_EQ(shoulder.name, "shoulder");
  EXPECT_EQ(shoulder.lower, -1.0);
  EXPECT_EQ(shoulder.upper, 2.0);
  EXPECT_EQ(shoulder.speed, 1.5);
  EXPECT_TRUE(shoulder.axis_L.isApprox(Eigen::Vector3d(0, 0, 1)));
  ASSERT_EQ(model.links[0].body.size(), 1U);
  EXPECT_EQ(std::get<geometry::Cylinder>(model.links[0].body[0].shape).height, 0.4);
  EXPECT_EQ(model.links[0].body[0].X_AS.translation().z(), 1.0);
}

TEST(LinkPoses, TurnEachLinkWithItsJointAndAllBehindIt) {
  const RobotModel model = Parse(std::string(kLinks) + kShoulder + kElbow);
  const std::vector<Pose> X_RL = LinkPoses(model, {0.0, std::numbers::pi / 2, 0.0});
  // A quarter turn about z, then 0.3 m along what was x, then another quarter turn.
  EXPECT_TRUE(X_RL[2].translation().isApprox(Eigen::Vector3d(0, 0.3, 0.5), 1e-12));
  EXPECT_TRUE((X_RL[2].linear() * Eigen::Vector3d::UnitX()).isApprox(-Eigen::Vector3d::UnitX()));
}

TEST(ParseUrdf, RefusesWhatIsNoUrdf) {
  EXPECT_THROWS(ParseUrdf("joints: 7", "arm.yaml"), ConfigError, "arm.yaml: is no usable URDF");
  EXPECT_THROWS(ParseUrdf("", "empty.urdf"), ConfigError, "empty.urdf: is no usable URDF");
  EXPECT_THROWS(LoadUrdf("no/such.urdf"), ConfigError, "no/such.urdf");
}

TEST(ParseUrdf, NamesAMissingLink) {
  EXPECT_THROWS(
      Parse(std::string(R"(<link name="base"/><link name="upper"/>)") + kShoulder + kElbow),
      ConfigError, "child link [lower] of joint [elbow] not found");
  EXPECT_THROWS(
      Parse(std::string(R"(<link name="upper"/><link name="lower"/>)") + kShoulder + kElbow),
      ConfigError, "parent link [base] of joint [shoulder] not found");
}

TEST(ParseUrdf, NamesALoop) {
  const std::string back = R"(
    <joint name="back" type="fixed"><parent link="lower"/><child link="base"/></joint>)";
  EXPECT_THROWS(Parse(std::string(kLinks) + kShoulder + kElbow + back), ConfigError,
                "No root link found");
  const std::string across = R"(
    <joint name="across" type="fixed"><parent link="base"/><child link="lower"/></joint>)";
  EXPECT_THROWS(Parse(std::string(kLinks) + kShoulder + kElbow + across), ConfigError,
                "link 'lower' is the child of joint 'across' and of joint 'elbow': a loop");
  const std::string apart = R"(<link name="a"/><link name="b"/>
    <joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>
    <joint name="ba" type="fixed"><parent link="b"/><child link="a"/></joint>)";
  EXPECT_THROWS(Parse(std::string(kLinks) + kShoulder + kElbow + apart), ConfigError,
                "link 'a' does not hang on the root 'base': it is in a loop");
}

TEST(ParseUrdf, NamesAJointWithoutLimits) {
  ExpectShoulderRefused(R"(<limit lower="-1" upper="2" velocity="1.5" effort="1"/>)", "",
                        "[shoulder] is of type REVOLUTE but it does not specify limits");
  ExpectShoulderRefused("revolute", "continuous", "joint 'shoulder' is continuous, without limits");
}

TEST(ParseUrdf, NamesLimitsThatContradictEachOther) {
  ExpectShoulderRefused("upper=\"2\"", "upper=\"-1.5\"",
                        "the limits of joint 'shoulder' contradict each other: lower -1 rad must "
                        "be less than upper -1.5 rad");
  ExpectShoulderRefused("velocity=\"1.5\"", "velocity=\"0\"",
                        "the velocity limit of joint 'shoulder' is 0 rad/s");
}

TEST(ParseUrdf, NamesAnAxisWithoutDirection) {
  ExpectShoulderRefused("0 0 2", "0 0 0",
                        "the axis (0, 0, 0) of joint 'shoulder' has no direction");
}

TEST(ParseUrdf, NamesAJointOfAnotherKind) {
  ExpectShoulderRefused("revolute", "prismatic", "joint 'shoulder' is neither revolute nor fixed");
}

TEST(ParseUrdf, NamesABodyThatIsNone) {
  const auto with_body = [](const std::string& geometry) {
    return R"(<link name="base"><collision><geometry>)" + geometry +
           R"(</geometry></collision></link>)";
  };
  EXPECT_THROWS(Parse(with_body(R"(<sphere radius="0"/>)")), ConfigError,
                "link 'base' has a body with a radius of 0 m");
  EXPECT_THROWS(Parse(with_body(R"(<mesh filename="base.stl"/>)")), ConfigError,
                "link 'base' has a mesh for a body");
}

TEST(RobotModel, NamesTheLinksThatThereAre) {
  EXPECT_THROWS(Parse(std::string(kLinks) + kShoulder + kElbow).IndexOf("hand"), ConfigError,
                "robot 'toy' has no link 'hand'; its links are 'base', 'upper', 'lower'");
}

}  // namespace
}  // namespace secondlook::kinematics
