#include "lib/planning/motion/arm_way.h"

#include <gtest/gtest.h>

#include "lib/planning/motion/stop_and_go.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector2d;

const std::vector<hal::JointInfo> kJoints{{"a", -4.0, 4.0, 1.0, 2.0}, {"b", -4.0, 4.0, 1.0, 2.0}};
const Vector2d kHome(0.0, 0.0);

/// Where the arm stands on its way.
std::vector<Eigen::VectorXd> StopsOf(const hal::JointTrajectory& trajectory) {
  std::vector<Eigen::VectorXd> stops;
  for (const hal::JointKnot& knot : trajectory.knots) {
    if (knot.v.isZero()) stops.push_back(knot.q);
  }
  return stops;
}

TEST(ArmWay, OfAFoldedArmIsNoMotion) {
  EXPECT_TRUE(ArmWay(kHome).Back(kHome, kJoints).knots.empty());
  // Within what encoders err.
  EXPECT_TRUE(ArmWay(kHome).Back(Vector2d(0.005, -0.005), kJoints).knots.empty());
}

TEST(ArmWay, GoesBackByTheWaypointsOfAllMotions) {
  const Vector2d corner(1.0, 0.0);
  const Vector2d first(1.0, 1.0);
  const Vector2d second(2.0, 1.0);
  ArmWay way(kHome);
  way.Follow(StopAndGo({kHome, corner, first}, kJoints), first);
  way.Follow(StopAndGo({first, second}, kJoints), second);
  const Vector2d measured = second + Vector2d(0.002, 0.0);
  const hal::JointTrajectory back = way.Back(measured, kJoints);
  EXPECT_NO_THROW(hal::CheckTrajectory(back, "arm", kJoints, measured));
  const std::vector<Eigen::VectorXd> stops = StopsOf(back);
  ASSERT_EQ(stops.size(), 4U);
  EXPECT_EQ(stops[0], measured);
  EXPECT_EQ(stops[1], first);
  EXPECT_EQ(stops[2], corner);
  EXPECT_EQ(stops[3], kHome);
}

TEST(ArmWay, FromWhereItWasStoppedLeavesOutWhatIsBehind) {
  const Vector2d corner(1.0, 0.0);
  const Vector2d stopped(0.5, 0.0);
  ArmWay way(kHome);
  way.Follow(StopAndGo({kHome, corner, Vector2d(1.0, 1.0)}, kJoints), stopped);
  const std::vector<Eigen::VectorXd> stops = StopsOf(way.Back(stopped, kJoints));
  ASSERT_EQ(stops.size(), 2U);
  EXPECT_EQ(stops[0], stopped);
  EXPECT_EQ(stops[1], kHome);
}

TEST(ArmWay, IsForgottenOnceItWasGoneBack) {
  const Vector2d there(1.0, 1.0);
  ArmWay way(kHome);
  way.Follow(StopAndGo({kHome, Vector2d(1.0, 0.0), there}, kJoints), there);
  way.Follow(way.Back(there, kJoints), kHome);
  EXPECT_TRUE(way.Back(kHome, kJoints).knots.empty());
  // The next way back is that of the next motion alone.
  const Vector2d other(0.0, 1.0);
  way.Follow(StopAndGo({kHome, other}, kJoints), other);
  EXPECT_EQ(StopsOf(way.Back(other, kJoints)).size(), 2U);
}

}  // namespace
}  // namespace secondlook::planning
