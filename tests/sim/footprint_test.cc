#include "sim/footprint.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/rng.h"
#include "sim/surroundings.h"

namespace secondlook::sim {
namespace {

using Eigen::Vector2d;

TEST(ConvexHull, DropsWhatLiesInsideAndTurnsCounterClockwise) {
  const std::vector<Vector2d> hull =
      ConvexHull({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}, {0.5, 0}, {1, 1}});
  ASSERT_EQ(hull.size(), 4U);
  double area = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d& a = hull[i];
    const Vector2d& b = hull[(i + 1) % 4];
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  EXPECT_DOUBLE_EQ(area, 1.0);
}

TEST(ConvexHull, OfFewerThanThreePointsIsThePoints) {
  EXPECT_EQ(ConvexHull({{1, 2}, {1, 2}}).size(), 1U);
  EXPECT_EQ(ConvexHull({{1, 2}, {3, 4}}).size(), 2U);
}

TEST(NearestOfSegment, KnowsCrossingsEndsAndPoints) {
  EXPECT_EQ(NearestOfSegment({0, 0}, {2, 0}, {1, -1}, {1, 1}).distance, 0.0);
  EXPECT_DOUBLE_EQ(NearestOfSegment({0, 0}, {2, 0}, {1, 1}, {1, 3}).distance, 1.0);
  EXPECT_DOUBLE_EQ(NearestOfSegment({0, 0}, {2, 0}, {5, 4}, {5, 9}).distance, 5.0);
  EXPECT_DOUBLE_EQ(NearestOfSegment({0, 0}, {0, 0}, {3, 4}, {3, 4}).distance, 5.0);
}

TEST(Footprint, DistanceIsThatOfTheNearestOfManyPointsOnBoth) {
  // Against brute force: the distance between densely sampled points of box and segment.
  Rng rng(2);
  for (int trial = 0; trial < 50; ++trial) {
    Pose X_WM = Pose::Identity();
    X_WM.linear() = RotationFromRollPitchYaw(0, 0, rng.Uniform(-3, 3));
    X_WM.translation() << rng.Uniform(-2, 2), rng.Uniform(-2, 2), 0.0;
    const Footprint box = MakeFootprint("box", geometry::MakeBox({0.6, 0.3, 1}, {1, 1, 1}), X_WM);
    const Vector2d a(rng.Uniform(-2, 2), rng.Uniform(-2, 2));
    const Vector2d b(rng.Uniform(-2, 2), rng.Uniform(-2, 2));
    double brute = 1e9;
    for (int i = 0; i <= 60; ++i) {
      for (int j = 0; j <= 60; ++j) {
        const Eigen::Vector3d p_M(0.6 * (i / 60.0 - 0.5), 0.3 * (j / 60.0 - 0.5), 0);
        const Vector2d p = (X_WM * p_M).head<2>();
        for (int k = 0; k <= 60; ++k) brute = std::min(brute, (a + k / 60.0 * (b - a) - p).norm());
      }
    }
    const Nearest nearest = NearestOf(box, a, b);
    EXPECT_LE(nearest.distance, brute + 1e-6);
    EXPECT_GE(nearest.distance, brute - 0.05);
  }
}

TEST(Surroundings, FindsTheNearestThingInTheWay) {
  Surroundings surroundings;  // a box of 1 m at the origin, a disc of 0.5 m at (3, 0)
  surroundings.fixed.push_back(
      MakeFootprint("box", geometry::MakeBox({1, 1, 1}, {1, 1, 1}), Pose::Identity()));
  surroundings.moving.push_back({"person", {3.0, 0.0}, 0.5});
  const auto seen = [&](const Vector2d& a, const Vector2d& b, double reach, double berth) {
    return surroundings.InTheWay(a, b, reach, berth);
  };
  EXPECT_DOUBLE_EQ(seen({1.4, 0.0}, {0.9, 0.0}, 0.45, 0.0).value().x(), 0.5);
  EXPECT_FALSE(seen({1.4, 0.0}, {0.9, 0.0}, 0.35, 0.0).has_value());
  EXPECT_FALSE(seen({1.5, 0.0}, {2.0, 0.0}, 0.45, 0.0).has_value());
  EXPECT_DOUBLE_EQ(seen({1.5, 0.0}, {2.0, 0.0}, 0.45, 0.1).value().x(), 2.5);
}

TEST(Surroundings, WhatIsBesideOrBehindIsNotInTheWayAndHidesNothingAhead) {
  Surroundings surroundings;
  surroundings.fixed.push_back(
      MakeFootprint("box", geometry::MakeBox({1, 1, 1}, {1, 1, 1}), Pose::Identity()));
  // Along its side, 0.1 m away; away from it; past it towards another.
  EXPECT_FALSE(surroundings.InTheWay({-0.2, 0.6}, {0.2, 0.6}, 0.3, 0.0).has_value());
  EXPECT_FALSE(surroundings.InTheWay({0.6, 0.0}, {1.0, 0.0}, 0.3, 0.0).has_value());
  surroundings.moving.push_back({"person", {1.0, 0.6}, 0.2});
  EXPECT_NEAR(surroundings.InTheWay({-0.2, 0.6}, {0.7, 0.6}, 0.3, 0.0).value().x(), 0.8, 1e-9);
}

}  // namespace
}  // namespace secondlook::sim
