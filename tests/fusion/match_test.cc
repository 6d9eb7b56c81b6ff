#include "lib/fusion/match.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::fusion {
namespace {

/// A patch of points 5 mm apart from (x, y), `width` by `depth` [m].
Footprint Patch(double x, double y, double width, double depth) {
  std::vector<Eigen::Vector3d> points;
  for (double u = 0.0; u < width; u += 0.005) {
    for (double v = 0.0; v < depth; v += 0.005) points.emplace_back(x + u, y + v, 0.8);
  }
  return Footprint(points, 0.01);
}

TEST(Footprint, OverlapsFullyWithWhatContainsIt) {
  EXPECT_EQ(Patch(0.02, 0.02, 0.05, 0.05).OverlapWith(Patch(0, 0, 0.1, 0.1)), 1.0);
  EXPECT_EQ(Patch(0, 0, 0.1, 0.1).OverlapWith(Patch(0.02, 0.02, 0.05, 0.05)), 1.0);
}

TEST(Footprint, DoesNotOverlapAcrossAGapOfThreeCentimetres) {
  EXPECT_EQ(Patch(0, 0, 0.1, 0.1).OverlapWith(Patch(0.13, 0, 0.1, 0.1)), 0.0);
}

TEST(Footprint, IsNothingWithoutPoints) {
  EXPECT_EQ(Footprint({}, 0.01).OverlapWith(Patch(0, 0, 0.1, 0.1)), 0.0);
}

Seen Thing(double x, double y, double width, double depth, double z = 0.8) {
  std::vector<Eigen::Vector3d> points;
  for (double u = 0.0; u < width; u += 0.005) {
    for (double v = 0.0; v < depth; v += 0.005) points.emplace_back(x + u, y + v, z);
  }
  return Seen(points, 0.01);
}

TEST(Footprint, ReachesAsFarAsItIsAsked) {
  EXPECT_EQ(Patch(0, 0, 0.1, 0.1).OverlapWith(Patch(0.13, 0, 0.02, 0.1), 5), 1.0);
}

TEST(PointCovariance, GrowsWithTheLever) {
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  covariance(2, 2) = 0.01 * 0.01;    // 0.01 rad about z…
  covariance(3, 3) = 0.002 * 0.002;  // …and 2 mm along x
  const Eigen::Matrix3d of_point = PointCovariance(covariance, {0.0, 1.0, 0.0});
  EXPECT_NEAR(of_point(0, 0), 0.01 * 0.01 + 0.002 * 0.002, 1e-12);
  EXPECT_NEAR(of_point(1, 1), 0.0, 1e-12);
  EXPECT_NEAR(PointCovariance(covariance, {1.0, 0.0, 0.0})(1, 1), 1e-4, 1e-12);
}

TEST(MatchSeen, KeepsThinThingsTogetherAsFarAsRegistrationErrs) {
  Rng rng(1);
  MatchGate gate;
  const double sigma = 0.012;
  gate.error_W = sigma * sigma * Eigen::Matrix3d::Identity();
  int together = 0;
  int without_error = 0;
  for (int i = 0; i < 400; ++i) {
    const std::vector<Seen> rod{
        Thing(rng.Gaussian(sigma), rng.Gaussian(sigma), 0.008, 0.15, 0.8 + rng.Gaussian(sigma))};
    const std::vector<Seen> known{Thing(0, 0, 0.008, 0.15)};
    if (MatchSeen(rod, known, gate).size() == 1U) ++together;
    if (MatchSeen(rod, known, {}).size() == 1U) ++without_error;
  }
  EXPECT_GE(together, 380) << "two sigma across, 99 % in all";
  EXPECT_LT(without_error, 300);
}

TEST(MatchSeen, TellsAThingFromOneThatWasPutFarBesideIt) {
  Rng rng(2);
  MatchGate gate;
  gate.error_W = 1e-5 * Eigen::Matrix3d::Identity();
  for (int i = 0; i < 200; ++i) {
    const double angle = rng.Uniform(0.0, 6.28);
    const double distance = rng.Uniform(0.16, 0.5);  // more than the diagonal of 10 cm
    const std::vector<Seen> moved{
        Thing(distance * std::cos(angle), distance * std::sin(angle), 0.1, 0.1)};
    EXPECT_EQ(MatchSeen(moved, {Thing(0, 0, 0.1, 0.1)}, gate).size(), 2U) << distance;
  }
}

TEST(MatchSeen, TellsWhatIsOnAShelfFromWhatIsBelow) {
  EXPECT_EQ(MatchSeen({Thing(0, 0, 0.1, 0.1, 1.1)}, {Thing(0, 0, 0.1, 0.1, 0.8)}, {}).size(), 2U);
}

TEST(MatchSeen, TellsSeenNewAndUnseenApart) {
  const auto matches = MatchSeen({Thing(0, 0, 0.1, 0.1), Thing(0.5, 0, 0.1, 0.1)},
                                 {Thing(1, 0, 0.1, 0.1), Thing(0.01, 0, 0.1, 0.1)}, {});
  ASSERT_EQ(matches.size(), 3U);
  EXPECT_EQ(matches[0].detections, std::vector<int>{0});
  EXPECT_EQ(matches[0].objects, std::vector<int>{1});
  EXPECT_EQ(matches[1].detections, std::vector<int>{1});
  EXPECT_TRUE(matches[1].objects.empty());
  EXPECT_TRUE(matches[2].detections.empty());
  EXPECT_EQ(matches[2].objects, std::vector<int>{0});
}

TEST(MatchSeen, JoinsTwoObjectsThatOneDetectionCovers) {
  const auto matches =
      MatchSeen({Thing(0, 0, 0.2, 0.1)}, {Thing(0, 0, 0.05, 0.1), Thing(0.15, 0, 0.05, 0.1)}, {});
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].objects, (std::vector<int>{0, 1}));
}

TEST(MatchSeen, JoinsTwoDetectionsOfOneObject) {
  const auto matches =
      MatchSeen({Thing(0, 0, 0.05, 0.1), Thing(0.15, 0, 0.05, 0.1)}, {Thing(0, 0, 0.2, 0.1)}, {});
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].detections, (std::vector<int>{0, 1}));
}

}  // namespace
}  // namespace secondlook::fusion
