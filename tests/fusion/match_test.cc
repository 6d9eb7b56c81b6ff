#include "lib/fusion/match.h"

#include <gtest/gtest.h>

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

TEST(MatchByFootprint, TellsSeenNewAndUnseenApart) {
  const auto matches = MatchByFootprint({Patch(0, 0, 0.1, 0.1), Patch(0.5, 0, 0.1, 0.1)},
                                        {Patch(1, 0, 0.1, 0.1), Patch(0.01, 0, 0.1, 0.1)}, 0.3);
  ASSERT_EQ(matches.size(), 3U);
  EXPECT_EQ(matches[0].detections, std::vector<int>{0});
  EXPECT_EQ(matches[0].objects, std::vector<int>{1});
  EXPECT_EQ(matches[1].detections, std::vector<int>{1});
  EXPECT_TRUE(matches[1].objects.empty());
  EXPECT_TRUE(matches[2].detections.empty());
  EXPECT_EQ(matches[2].objects, std::vector<int>{0});
}

TEST(MatchByFootprint, JoinsTwoObjectsThatOneDetectionCovers) {
  const auto matches = MatchByFootprint({Patch(0, 0, 0.2, 0.1)},
                                        {Patch(0, 0, 0.05, 0.1), Patch(0.15, 0, 0.05, 0.1)}, 0.3);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].objects, (std::vector<int>{0, 1}));
}

TEST(MatchByFootprint, JoinsTwoDetectionsOfOneObject) {
  const auto matches = MatchByFootprint({Patch(0, 0, 0.05, 0.1), Patch(0.15, 0, 0.05, 0.1)},
                                        {Patch(0, 0, 0.2, 0.1)}, 0.3);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].detections, (std::vector<int>{0, 1}));
}

}  // namespace
}  // namespace secondlook::fusion
