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

  std::vector<world::Look> Views() const {
    const Pose X_WB = ToPose(carrier_.X_WB);
    std::vector<geometry::PlacedShape> body_W = arm_.Body(carrier_.q);
    for (geometry::PlacedShape& part : body_W) part.X_AS = X_WB * part.X_AS;
    const ArmCollision collision(arm_, X_WB,
                                 ObstaclesAround(X_WB * Vector3d(-0.05, -0.1, 0.7), ReachOf(arm_),
                                                 space_, {table_W_}, body_W));
    return ArmViews(target_W_, 3, carrier_, collision, 1, config_);
  }

  static int Feasible(const std::vector<world::Look>& views) {
    return static_cast<int>(std::count_if(views.begin(), views.end(),
                                          [](const world::Look& view) { return view.feasible; }));
  }

  kinematics::Chain arm_;
  world::VoxelSpace space_;
  world::SupportPlane table_W_;
  ArmCarrier carrier_{{"arm", JointsOf(arm_, 2.5)}, {arm_, Pose::Identity()}, {}, {}, {}, {}};
  Vector3d target_W_{0.75, 0.1, 0.8};
  ArmViewsConfig config_;
};

TEST_F(ArmViewsOfATable, LookAtTheTargetFromWhereTheArmIsThen) {
  const auto views = Views();
  EXPECT_EQ(views.size(), 48U);
  EXPECT_GE(Feasible(views), 3);
  for (const world::Look& view : views) {
    EXPECT_EQ(view.kind, "arm");
    EXPECT_EQ(view.way, world::LookWay::kArm);
    EXPECT_EQ(view.target, 3);
    EXPECT_EQ(view.X_WB, carrier_.X_WB);
    if (!view.feasible) {
      EXPECT_TRUE(view.arm_motion.knots.empty());
      continue;
    }
    const Pose X_WC =
        ToPose(carrier_.X_WB) * arm_.TipPose(view.arm_motion.knots.back().q) * carrier_.hand.X_EC;
    EXPECT_TRUE(X_WC.isApprox(view.X_WC, 1e-9));
    const Vector3d p_CT = X_WC.inverse() * target_W_;
    EXPECT_LE(p_CT.head<2>().norm(), 1e-3);
    EXPECT_TRUE(std::abs(p_CT.z() - 0.55) < 1e-3 || std::abs(p_CT.z() - 0.7) < 1e-3);
    EXPECT_EQ(view.arm_motion.knots.front().q, kHome);
    EXPECT_EQ(view.seconds, view.arm_motion.seconds());
    EXPECT_NO_THROW(hal::CheckTrajectory(view.arm_motion, "arm", carrier_.arm.joints, carrier_.q));
  }
}

TEST_F(ArmViewsOfATable, SayWhichCheckRefusedThem) {
  // The far side of a target 0.75 m away is out of reach.
  bool unreachable = false;
  for (const world::Look& view : Views()) {
    ASSERT_FALSE(view.checks.empty());
    EXPECT_EQ(view.checks.front().name, "range");
    if (view.feasible) {
      EXPECT_EQ(view.checks.size(), 5U);
      EXPECT_EQ(view.checks.back().name, "path");
      continue;
    }
    EXPECT_FALSE(view.checks.back().passed);
    EXPECT_EQ(view.reason, view.checks.back().name + ": " + view.checks.back().detail);
    unreachable |= view.reason.starts_with("inverse kinematics: unreachable: the nearest is");
  }
  EXPECT_TRUE(unreachable);
}

TEST_F(ArmViewsOfATable, KeepToTheRangeOfADepthCameraAlone) {
  carrier_.camera.min_depth = 0.6;
  int refused = 0;
  for (const world::Look& view : Views()) {
    refused += view.reason == "range: 0.55 m in 0.60..6.00 m";
  }
  EXPECT_EQ(refused, 24);
  carrier_.camera.has_depth = false;
  for (const world::Look& view : Views()) EXPECT_NE(view.checks.front().name, "range");
}

TEST_F(ArmViewsOfATable, AreRefusedWhereTheArmWouldTouchSomething) {
  const int before = Feasible(Views());
  Occupy({Vector3d(0.3, -0.6, 0.8), Vector3d(0.45, 0.6, 1.5)}, &space_);  // a wall before the table
  const auto views = Views();
  EXPECT_LT(Feasible(views), before);
  bool collides = false;
  for (const world::Look& view : views) {
    collides |= view.reason.starts_with("collision: link '") &&
                view.reason.find("occupied space") != std::string::npos;
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
    EXPECT_EQ(first[i].reason, second[i].reason);
    EXPECT_EQ(first[i].seconds, second[i].seconds);
    EXPECT_TRUE(first[i].X_WC.isApprox(second[i].X_WC, 0.0));
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
