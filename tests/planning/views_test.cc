#include "lib/planning/views.h"

#include <algorithm>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector3d;
using secondlook::testing::MakeBase;
using secondlook::testing::MakeSupport;
using world::VoxelSpace;

constexpr double kPi = std::numbers::pi;

CameraCarrier MakeCarrier() {
  return {MakeBase(),
          {"head", {-2.0, -0.8}, {2.0, 1.2}, 1.0},
          kinematics::HeadCalibration::AtHeight(1.2),
          {"camera", {640, 480, 577.0, 577.0, 319.5, 239.5}, true, 0.5, 4.0}};
}

/// A table of 0.8 m x 0.6 m around the origin, the robot in front of it.
struct Room {
  VoxelSpace space;
  std::vector<world::SupportPlane> supports_W{MakeSupport({0, 0, 0.75}, {0.8, 0.6})};
  Pose2 X_WB{-1.3, 0.0, 0.0};

  std::vector<world::Look> Candidates(const Vector3d& p_WT, const CameraCarrier& carrier) const {
    const CollisionChecker collision(space, supports_W, carrier.base);
    const CostMap map(space, supports_W, carrier.base, {0.0, 0.0});
    const Routes routes(map, X_WB, carrier.base);
    return CandidateViews(p_WT, 7, carrier, {collision, routes, {0.0, 0.3}});
  }
};

const world::LookCheck& Last(const world::Look& look) { return look.checks.back(); }

TEST(CandidateViews, LieOnTwoUniformRingsAndLookAtTheTarget) {
  const Vector3d p_WT(0.1, -0.05, 0.85);
  const std::vector<world::Look> looks = Room().Candidates(p_WT, MakeCarrier());
  ASSERT_EQ(looks.size(), 38U);
  std::vector<double> angles;
  for (int i = 0; i < 38; ++i) {
    const world::Look& look = looks[i];
    const double dx = look.X_WB.x - p_WT.x();
    const double dy = look.X_WB.y - p_WT.y();
    EXPECT_NEAR(std::hypot(dx, dy), i < 19 ? 0.95 : 1.35, 1e-9);
    EXPECT_NEAR(WrapAngle(std::atan2(-dy, -dx) - look.X_WB.yaw), 0.0, 1e-9);
    angles.push_back(std::atan2(dy, dx));
    EXPECT_EQ(look.target, 7);
    EXPECT_EQ(look.kind, "aspect_graph");
    // The target lies on the optical axis of a camera 1.2 m above the base's centre.
    const Vector3d p_CT = look.X_WC.inverse() * p_WT;
    EXPECT_NEAR(p_CT.head<2>().norm(), 0.0, 1e-6);
    EXPECT_NEAR(p_CT.z(), std::hypot(i < 19 ? 0.95 : 1.35, 0.35), 1e-6);
    EXPECT_NEAR(look.head.pan, 0.0, 1e-9);
    EXPECT_NEAR(look.head.tilt, std::atan2(0.35, i < 19 ? 0.95 : 1.35), 1e-6);
  }
  std::sort(angles.begin(), angles.end());
  for (int i = 1; i < 38; ++i) EXPECT_NEAR(angles[i] - angles[i - 1], 2.0 * kPi / 38, 1e-9);
}

TEST(CandidateViews, OneThatIsFreeHasPassedAllChecksAndHasAPath) {
  const std::vector<world::Look> looks = Room().Candidates({0, 0, 0.85}, MakeCarrier());
  int feasible = 0;
  for (const world::Look& look : looks) {
    ASSERT_FALSE(look.checks.empty());
    EXPECT_EQ(look.feasible, Last(look).passed);
    if (!look.feasible) {
      EXPECT_THAT(look.reason, ::testing::HasSubstr(Last(look).name));
      EXPECT_TRUE(look.path_W.empty());
      continue;
    }
    ++feasible;
    ASSERT_EQ(look.checks.size(), 4U);
    EXPECT_EQ(look.checks[0].name, "pan-tilt limits");
    EXPECT_EQ(look.checks[1].name, "range");
    EXPECT_EQ(look.checks[2].name, "collision");
    EXPECT_EQ(look.checks[3].name, "path");
    ASSERT_FALSE(look.path_W.empty());
    EXPECT_EQ(look.path_W.back(), look.X_WB);
    EXPECT_GE(look.seconds, look.metres / 0.5);
  }
  EXPECT_EQ(feasible, 38);  // half the diagonal, grown, and 0.33 m make 0.87 m
}

TEST(CandidateViews, AnObstacleRefusesThoseThatWouldTouchIt) {
  Room room;
  for (double z = 0.1; z < 1.0; z += 0.02) room.space.MarkOccupied({{1.35, 0.0, z}});
  const std::vector<world::Look> looks = room.Candidates({0, 0, 0.85}, MakeCarrier());
  int refused = 0;
  for (const world::Look& look : looks) {
    const double away = std::hypot(look.X_WB.x - 1.35, look.X_WB.y);
    if (away < 0.32) {
      EXPECT_FALSE(look.feasible);
      EXPECT_EQ(Last(look).name, "collision");
      EXPECT_THAT(look.reason, ::testing::HasSubstr("with the map at (1.3"));
      ++refused;
    }
    if (away > 0.42) {
      EXPECT_TRUE(look.feasible) << look.reason;
    }
  }
  EXPECT_GE(refused, 1);
}

TEST(CandidateViews, TheHeadsLimitsAndTheCamerasRangeRefuse) {
  CameraCarrier carrier = MakeCarrier();
  carrier.pan_tilt.upper.tilt = 0.3;  // the inner ring needs 20.2 degrees, the outer 14.5
  carrier.camera.max_depth = 1.2;     // the outer ring is 1.39 m away
  const std::vector<world::Look> looks = Room().Candidates({0, 0, 0.85}, carrier);
  for (int i = 0; i < 38; ++i) {
    EXPECT_FALSE(looks[i].feasible);
    EXPECT_EQ(Last(looks[i]).name, i < 19 ? "pan-tilt limits" : "range");
  }
  EXPECT_THAT(looks[0].reason, ::testing::HasSubstr("tilt 20.2 in -45.8..17.2 deg"));
  EXPECT_THAT(looks[19].reason, ::testing::HasSubstr("1.39 m in 0.50..1.20 m"));
}

TEST(CandidateViews, LimitsThatContradictEachOtherRefuseAll) {
  CameraCarrier carrier = MakeCarrier();
  carrier.pan_tilt.lower.tilt = 0.9;
  carrier.pan_tilt.upper.tilt = -0.9;
  for (const world::Look& look : Room().Candidates({0, 0, 0.85}, carrier)) {
    EXPECT_FALSE(look.feasible);
    EXPECT_THAT(look.reason, ::testing::StartsWith("pan-tilt limits: "));
  }
}

TEST(CandidateViews, OfATargetOutsideOfTheMapAreAllRefusedWithAReason) {
  for (const world::Look& look : Room().Candidates({20.0, 0.0, 0.85}, MakeCarrier())) {
    EXPECT_FALSE(look.feasible);
    EXPECT_THAT(look.reason, ::testing::HasSubstr("lies outside of the map"));
  }
}

TEST(UsefulDistances, FollowFromTheDepthsNoiseAndThePixelsOnTheTarget) {
  // 4 mm = 1.2 mm + 1.9 mm/m^2 (z - 0.4 m)^2 at z = 1.614 m; the camera is 0.35 m above the target.
  const Vector3d center(0, 0, 0.85);
  const auto box = [&](double side) {
    return Eigen::AlignedBox3d(center - Vector3d::Constant(0.5 * side),
                               center + Vector3d::Constant(0.5 * side));
  };
  DistanceRange range = UsefulDistances(box(0.2), MakeCarrier());
  const double diagonal = 0.2 * std::sqrt(3.0);
  EXPECT_NEAR(range.far, std::sqrt(1.614 * 1.614 - 0.35 * 0.35), 1e-3);
  EXPECT_NEAR(range.near, std::sqrt(std::pow(0.5 + 0.5 * diagonal, 2) - 0.35 * 0.35), 1e-6);
  // A small thing has to be nearer: 0.05 m sqrt(3) spans 60 px at 0.833 m.
  range = UsefulDistances(box(0.05), MakeCarrier());
  EXPECT_NEAR(range.far, std::sqrt(0.833 * 0.833 - 0.35 * 0.35), 2e-3);
  // A large one farther: 0.8 m sqrt(3) fills 480 px at 1.666 m, where depth is no good any more.
  range = UsefulDistances(box(0.8), MakeCarrier());
  EXPECT_GT(range.near, range.far);
}

TEST(PlacedViews, StandFreeAndReachableAtUsefulDistancesAllAround) {
  const Room room;
  const CameraCarrier carrier = MakeCarrier();
  const Eigen::AlignedBox3d box_W(Vector3d(0.2, -0.1, 0.75), Vector3d(0.4, 0.1, 0.95));
  const CollisionChecker collision(room.space, room.supports_W, carrier.base);
  const CostMap map(room.space, room.supports_W, carrier.base, {0.0, 0.0});
  const Routes routes(map, room.X_WB, carrier.base);
  const std::vector<world::Look> looks =
      PlacedViews(box_W, 7, carrier, {collision, routes, {0.0, 0.3}});
  const DistanceRange range = UsefulDistances(box_W, carrier);
  ASSERT_GE(looks.size(), 12U);
  EXPECT_LE(looks.size(), 24U);
  int left = 0;
  for (const world::Look& look : looks) {
    EXPECT_TRUE(look.feasible);
    EXPECT_EQ(look.target, 7);
    EXPECT_FALSE(collision.Touches(look.X_WB).has_value());
    EXPECT_EQ(look.path_W.back(), look.X_WB);
    const double distance = std::hypot(look.X_WB.x - 0.3, look.X_WB.y);
    EXPECT_GE(distance, range.near - 1e-9);
    EXPECT_LE(distance, range.far + 1e-9);
    if (look.X_WB.y > 0.0) ++left;
  }
  EXPECT_GE(left, static_cast<int>(looks.size()) / 4);
  EXPECT_LE(left, 3 * static_cast<int>(looks.size()) / 4);
  EXPECT_THROWS(PlacedViews(Eigen::AlignedBox3d(), 7, carrier, {collision, routes, {0.0, 0.3}}),
                InvalidArgument, "the box of target 7 is empty");
}

TEST(CandidateViews, RefuseBadInput) {
  EXPECT_THROWS(Room().Candidates({NAN, 0, 0}, MakeCarrier()), InvalidArgument,
                "p_WT = (nan, 0, 0) m of target 7");
  ViewsConfig config;
  config.poses = 37;
  EXPECT_THROWS(config.Validate(), ConfigError, "poses = 37 must be an even number");
  config = {};
  config.max_depth_sigma_m = 0.0;
  EXPECT_THROWS(config.Validate(), ConfigError, "max_depth_sigma_m = 0 must lie in 0.0012..1");
  config = {};
  config.inner_radius_m = 2.0;
  EXPECT_THROWS(config.Validate(), ConfigError, "inner_radius_m = 2");
}

}  // namespace
}  // namespace secondlook::planning
