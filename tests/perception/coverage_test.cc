#include "lib/perception/coverage.h"

#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/half_ball.h"

namespace secondlook::perception {
namespace {

constexpr double kRadius = 0.05;
constexpr double kBall = 4.0 * std::numbers::pi * kRadius * kRadius;

TEST(Coverage, ABallSeenFromOneSideIsHalfOfIt) {
  // Its hole is a disc of half the area of what is unseen: Eq. 6 says 2/3.
  const world::PartialMesh half =
      tests::PartOfBall(kRadius, 100, [](const Eigen::Vector3f& p) { return p.x() > -1e-6F; });
  const Coverage coverage = EstimateCoverage(half, tests::LevelPlane(-0.1), 0.005);
  EXPECT_NEAR(coverage.filled, 0.5 * kBall, 0.01 * kBall);
  EXPECT_NEAR(coverage.Estimated(), 2.0 / 3.0, 0.01);
  EXPECT_NEAR(coverage.Reachable(), 0.5, 0.02);
}

TEST(Coverage, WhatItStandsOnIsNoLack) {
  const auto dome = [](const Eigen::Vector3f& p) { return p.z() > -1e-6F; };
  const world::PartialMesh half = tests::PartOfBall(kRadius, 100, dome);
  const Coverage standing = EstimateCoverage(half, tests::LevelPlane(-0.001), 0.005);
  EXPECT_NEAR(standing.Estimated(), 2.0 / 3.0, 0.01);
  EXPECT_EQ(standing.Reachable(), 1.0);
}

TEST(Coverage, WhatFacesTheSupportIsNoLack) {
  // A dome over a foot that it hides: its rim is high, but what is below it faces down.
  const auto dome = [](const Eigen::Vector3f& p) { return p.z() > -1e-6F; };
  const world::PartialMesh half = tests::PartOfBall(kRadius, 100, dome);
  const Coverage over = EstimateCoverage(half, tests::LevelPlane(-0.03), 0.005);
  EXPECT_NEAR(over.Estimated(), 2.0 / 3.0, 0.01);
  EXPECT_EQ(over.Reachable(), 1.0);
  // A bowl's inside, in turn, is seen from above.
  const auto bowl = [](const Eigen::Vector3f& p) { return p.z() < 1e-6F; };
  const world::PartialMesh open = tests::PartOfBall(kRadius, 100, bowl);
  EXPECT_LT(EstimateCoverage(open, tests::LevelPlane(-0.051), 0.005).Reachable(), 0.6);
}

TEST(Coverage, OfAClosedSurfaceIsWholeAndOfNoneIsNothing) {
  const auto all = [](const Eigen::Vector3f&) { return true; };
  const Coverage whole =
      EstimateCoverage(tests::PartOfBall(kRadius, 50, all), tests::LevelPlane(-0.1), 0.005);
  EXPECT_EQ(whole.Estimated(), 1.0);
  EXPECT_EQ(whole.Reachable(), 1.0);
  EXPECT_EQ(EstimateCoverage({}, tests::LevelPlane(0.0), 0.005).Reachable(), 0.0);
}

TEST(Above, KeepsTheTrianglesThatAreWhollyAbove) {
  const auto all = [](const Eigen::Vector3f&) { return true; };
  const world::PartialMesh ball = tests::PartOfBall(kRadius, 60, all);
  const world::PartialMesh above = Above(ball, tests::LevelPlane(-kRadius), 0.02);
  ASSERT_FALSE(above.mesh.empty());
  EXPECT_EQ(above.normals.size(), above.mesh.vertices.size());
  for (const Eigen::Vector3f& p : above.mesh.vertices) EXPECT_GT(p.z(), -0.03F);
  // The zone of a sphere is as large as that of its cylinder: 0.08 of 0.1 m high.
  EXPECT_NEAR(EstimateCoverage(above, tests::LevelPlane(-kRadius), 0.03).filled, 0.8 * kBall,
              0.03 * kBall);
}

}  // namespace
}  // namespace secondlook::perception
