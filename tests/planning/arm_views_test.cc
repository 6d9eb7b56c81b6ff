#include "lib/planning/arm_views.h"

#include <algorithm>
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

const Eigen::VectorXd kHome = Degrees({80, 45, 0, 112, 0, -105, 120});

class ArmViewsOfATable : public ::testing::Test {
 protected:
  ArmViewsOfATable() : arm_(SimulatedArm()), space_(FreeSpace()) {
    carrier_.hand.X_EC.translation() << 0.06, 0.0, 0.032;
    carrier_.camera = {"hand", {640, 480, 570, 570, 319.5, 239.5}, true, 0.5, 6.0};
    carrier_.X_WB = {0.1, 0.05, 0.0};
    carrier_.q = kHome;
    table_W_.offset = 0.75;
    table_W_.corners_A = {Vector3d(0.5, -.6, .75), Vector3d(1.3, -.6, .75), Vector3d(1.3, .6, .75),
                          Vector3d(0.5, .6, .75)};
  }

  std::vector<ArmLook> Views() const {
    const Pose X_WB = ToPose(carrier_.X_WB);
    std::vector<geometry::PlacedShape> body_W = arm_.Body(carrier_.q);
    for (geometry::PlacedShape& part : body_W) part.X_AS = X_WB * part.X_AS;
    const ArmCollision collision(arm_, X_WB,
                                 ObstaclesAround(X_WB * Vector3d(-0.05, -0.1, 0.7), Reach(arm_),
                                                 space_, {table_W_}, body_W));
    return ArmViews(target_W_, 3, carrier_, collision, 1, config_);
  }

  static int Feasible(const std::vector<ArmLook>& views) {
    return static_cast<int>(std::count_if(views.begin(), views.end(),
                                          [](const ArmLook& view) { return view.look.feasible; }));
  }

  kinematics::Chain arm_;
  world::VoxelSpace space_;
  world::SupportPlane table_W_;
  ArmCarrier carrier_{{"arm", JointsOf(arm_, 2.5)}, {arm_, Pose::Identity()}, {}, {}, {}};
  Vector3d target_W_{0.75, 0.1, 0.8};
  ArmViewsConfig config_;
};

TEST_F(ArmViewsOfATable, LookAtTheTargetFromWhereTheArmIsThen) {
  const auto views = Views();
  EXPECT_EQ(views.size(), 48U);
  EXPECT_GE(Feasible(views), 3);
  for (const ArmLook& view : views) {
    EXPECT_EQ(view.look.kind, "arm");
    EXPECT_EQ(view.look.target, 3);
    EXPECT_EQ(view.look.X_WB, carrier_.X_WB);
    if (!view.look.feasible) {
      EXPECT_TRUE(view.trajectory.knots.empty());
      continue;
    }
    const Pose X_WC = ToPose(carrier_.X_WB) * arm_.TipPose(view.q) * carrier_.hand.X_EC;
    EXPECT_TRUE(X_WC.isApprox(view.look.X_WC, 1e-9));
    const Vector3d p_CT = X_WC.inverse() * target_W_;
    EXPECT_LE(p_CT.head<2>().norm(), 1e-3);
    EXPECT_TRUE(std::abs(p_CT.z() - 0.55) < 1e-3 || std::abs(p_CT.z() - 0.7) < 1e-3);
    EXPECT_EQ(view.trajectory.knots.front().q, kHome);
    EXPECT_EQ(view.trajectory.knots.back().q, view.q);
    EXPECT_EQ(view.look.seconds, view.trajectory.seconds());
    EXPECT_NO_THROW(hal::CheckTrajectory(view.trajectory, "arm", carrier_.arm.joints, carrier_.q));
  }
}

TEST_F(ArmViewsOfATable, SayWhichCheckRefusedThem) {
  // The far side of a target 0.75 m away is out of reach.
  bool unreachable = false;
  for (const ArmLook& view : Views()) {
    ASSERT_FALSE(view.look.checks.empty());
    EXPECT_EQ(view.look.checks.front().name, "range");
    if (view.look.feasible) {
      EXPECT_EQ(view.look.checks.size(), 4U);
      EXPECT_EQ(view.look.checks.back().name, "path");
      continue;
    }
    EXPECT_FALSE(view.look.checks.back().passed);
    EXPECT_EQ(view.look.reason,
              view.look.checks.back().name + ": " + view.look.checks.back().detail);
    unreachable |= view.look.reason.starts_with("inverse kinematics: unreachable: the nearest is");
  }
  EXPECT_TRUE(unreachable);
}

TEST_F(ArmViewsOfATable, KeepToTheRangeOfADepthCameraAlone) {
  carrier_.camera.min_depth = 0.6;
  int refused = 0;
  for (const ArmLook& view : Views()) {
    refused += view.look.reason == "range: 0.55 m in 0.60..6.00 m";
  }
  EXPECT_EQ(refused, 24);
  carrier_.camera.has_depth = false;
  for (const ArmLook& view : Views()) EXPECT_NE(view.look.checks.front().name, "range");
}

TEST_F(ArmViewsOfATable, AreRefusedWhereTheArmWouldTouchSomething) {
  const int before = Feasible(Views());
  Occupy({Vector3d(0.3, -0.6, 0.8), Vector3d(0.45, 0.6, 1.5)}, &space_);  // a wall before the table
  const auto views = Views();
  EXPECT_LT(Feasible(views), before);
  bool collides = false;
  for (const ArmLook& view : views) {
    collides |= view.look.reason.starts_with("collision: link '") &&
                view.look.reason.find("occupied space") != std::string::npos;
  }
  EXPECT_TRUE(collides);
}

TEST_F(ArmViewsOfATable, AreNoneThatAreFeasibleWhereNothingWasSeenYet) {
  space_ = world::VoxelSpace();
  EXPECT_EQ(Feasible(Views()), 0);
}

TEST_F(ArmViewsOfATable, AreTheSameEveryTime) {
  const auto first = Views();
  const auto second = Views();
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].look.reason, second[i].look.reason);
    EXPECT_EQ(first[i].look.seconds, second[i].look.seconds);
    ASSERT_EQ(first[i].q.size(), second[i].q.size());
    if (first[i].q.size() > 0) {
      EXPECT_EQ(first[i].q, second[i].q);
    }
  }
}

TEST_F(ArmViewsOfATable, RefuseATargetThatIsNotFiniteAndAWrongConfig) {
  target_W_.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROWS(Views(), InvalidArgument, "arm views: the position p_WT = (nan, 0.1, 0.8) m");
  config_.outer_distance_m = 0.1;
  EXPECT_THROWS(Views(), ConfigError, "outer_distance_m = 0.1 must lie in 0.55..3");
}

}  // namespace
}  // namespace secondlook::planning
