#include "lib/fusion/cross_match.h"

#include <limits>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::fusion {
namespace {

const geometry::CameraModel kCamera{640, 480, 500.0, 500.0, 320.0, 240.0};

/// The second camera stands where the first one is.
const Pose kSame = Pose::Identity();

/// A box of 40 x 40 pixels around the image of a point at 1 m.
cv::Rect2d BoxAround(double x, double y) {
  return {320.0 + 500.0 * x - 20.0, 240.0 + 500.0 * y - 20.0, 40.0, 40.0};
}

TEST(MatchAcrossCameras, FindsThePartnersOfPermutedBoxes) {
  const CrossMatches found = MatchAcrossCameras(
      {{-0.3, 0.0, 1.0}, {0.0, 0.1, 1.0}, {0.3, 0.0, 1.0}},
      {BoxAround(0.3, 0.0), BoxAround(-0.3, 0.0), BoxAround(0.0, 0.1)}, kSame, kCamera);
  ASSERT_EQ(found.matches.size(), 3U);
  EXPECT_EQ(found.matches[0].box, 1);
  EXPECT_EQ(found.matches[1].box, 2);
  EXPECT_EQ(found.matches[2].box, 0);
  EXPECT_NEAR(found.matches[0].distance_px, 0.0, 1e-9);
  EXPECT_TRUE(found.unmatched.empty());
}

TEST(MatchAcrossCameras, MeasuresByTheEightPointsOfABoxAsThePaperDoes) {
  CrossMatchConfig config;
  config.distance = BoxDistance::kEightPoints;
  const auto distance = [&](double x, double y) {
    return MatchAcrossCameras({{x, y, 1.0}}, {BoxAround(0.0, 0.0)}, kSame, kCamera, config)
        .matches.at(0)
        .distance_px;
  };
  EXPECT_NEAR(distance(0.0, 0.0), 20.0, 1e-9);    // to the middle of an edge
  EXPECT_NEAR(distance(0.04, 0.04), 0.0, 1e-9);   // a corner
  EXPECT_NEAR(distance(0.02, 0.04), 10.0, 1e-9);  // between two points of the lower edge
}

TEST(MatchAcrossCameras, MeasuresFromTheCentreInHalfSides) {
  const cv::Rect2d wide(270.0, 230.0, 100.0, 20.0);
  const auto found = MatchAcrossCameras({{0.05, 0.0, 1.0}}, {wide}, kSame, kCamera);
  EXPECT_NEAR(found.matches.at(0).distance_px, 15.0,
              1e-9);  // half a half side, times (50 + 10) / 2
}

TEST(MatchAcrossCameras, GoesThroughThePoseBetweenTheCameras) {
  Pose X_BA = Pose::Identity();
  X_BA.translation() = Eigen::Vector3d(0.2, 0.0, 0.5);
  // The point (-0.2, 0, 0.5) of A is (0, 0, 1) in B.
  const CrossMatches found =
      MatchAcrossCameras({{-0.2, 0.0, 0.5}}, {BoxAround(0.0, 0.0)}, X_BA, kCamera);
  ASSERT_EQ(found.matches.size(), 1U);
}

TEST(MatchAcrossCameras, LeavesTheFartherOfTwoThatClaimOneBoxWithoutPartner) {
  const CrossMatches found = MatchAcrossCameras({{0.05, 0.0, 1.0}, {0.0, 0.0, 1.0}},
                                                {BoxAround(0.0, 0.0)}, kSame, kCamera);
  ASSERT_EQ(found.matches.size(), 1U);
  ASSERT_EQ(found.unmatched.size(), 1U);
  EXPECT_TRUE(found.unmatched[0].is_object);
  EXPECT_EQ(found.unmatched[0].reason, "nothing near it in the second camera");
}

TEST(MatchAcrossCameras, LetsTheLargerGroupAsk) {
  const CrossMatches found = MatchAcrossCameras(
      {{0.0, 0.0, 1.0}}, {BoxAround(0.3, 0.0), BoxAround(0.0, 0.0)}, kSame, kCamera);
  ASSERT_EQ(found.matches.size(), 1U);
  EXPECT_EQ(found.matches[0].box, 1);
  ASSERT_EQ(found.unmatched.size(), 1U);
  EXPECT_FALSE(found.unmatched[0].is_object);
  EXPECT_EQ(found.unmatched[0].index, 0);
}

TEST(MatchAcrossCameras, RefusesWhatIsTooFarApart) {
  const CrossMatches found =
      MatchAcrossCameras({{0.0, 0.0, 1.0}}, {BoxAround(0.2, 0.0)}, kSame, kCamera);
  EXPECT_TRUE(found.matches.empty());
  ASSERT_EQ(found.unmatched.size(), 2U);
  EXPECT_EQ(found.unmatched[0].reason, "100 px apart, 60 allowed");
}

TEST(MatchAcrossCameras, RefusesAMatchThatIsIrregularBesideTheOthers) {
  CrossMatchConfig config;
  config.position_sigma_m = 1.0;  // leaves this to the other gate
  const CrossMatches found = MatchAcrossCameras(
      {{-0.3, 0.0, 1.0}, {0.0, 0.1, 1.0}, {0.3, 0.0, 1.0}},
      {BoxAround(-0.3, 0.0), BoxAround(0.0, 0.1), BoxAround(0.41, 0.0)}, kSame, kCamera, config);
  EXPECT_EQ(found.matches.size(), 2U);
  EXPECT_EQ(found.unmatched[0].reason, "55 px apart, much farther than all others");
}

TEST(MatchAcrossCameras, RefusesACentroidBesideTheLineOfSightOfItsBox) {
  // 30 px beside the box at 1 m and f = 500 px: 60 mm.
  const CrossMatches found =
      MatchAcrossCameras({{0.1, 0.0, 1.0}}, {BoxAround(0.0, 0.0)}, kSame, kCamera);
  EXPECT_TRUE(found.matches.empty());
  EXPECT_EQ(found.unmatched[0].reason, "0.060 m beside its line of sight, 0.030 allowed");
}

TEST(MatchAcrossCameras, SaysWhenAnObjectIsBehindTheSecondCamera) {
  const CrossMatches found =
      MatchAcrossCameras({{0.0, 0.0, -1.0}}, {BoxAround(0.0, 0.0)}, kSame, kCamera);
  EXPECT_TRUE(found.matches.empty());
  EXPECT_EQ(found.unmatched[0].reason, "behind the second camera");
}

TEST(MatchAcrossCameras, RarelyPairsDifferentObjectsOfAClutteredTable) {
  // Eight objects of 8 cm, at least 10 cm apart, seen with the camera's pose wrong by 5 mm and
  // boxes
  // wrong by 3 px.
  Rng rng(1);
  int matched = 0;
  int wrong = 0;
  for (int scene = 0; scene < 200; ++scene) {
    std::vector<Eigen::Vector3d> objects;
    while (objects.size() < 8) {
      const Eigen::Vector3d p(rng.Uniform(-0.35, 0.35), rng.Uniform(-0.25, 0.25),
                              rng.Uniform(0.9, 1.1));
      bool apart = true;
      for (const Eigen::Vector3d& q : objects) apart = apart && (p - q).norm() > 0.1;
      if (apart) objects.push_back(p);
    }
    std::vector<cv::Rect2d> boxes;
    const Eigen::Vector3d error(rng.Gaussian(0.005), rng.Gaussian(0.005), rng.Gaussian(0.005));
    for (const Eigen::Vector3d& object : objects) {
      const Eigen::Vector3d p = object + error;
      const double side = 0.08 * 500.0 / p.z();
      boxes.emplace_back(320.0 + 500.0 * p.x() / p.z() - 0.5 * side + rng.Gaussian(3.0),
                         240.0 + 500.0 * p.y() / p.z() - 0.5 * side + rng.Gaussian(3.0), side,
                         side);
    }
    for (const CrossMatch& m : MatchAcrossCameras(objects, boxes, kSame, kCamera).matches) {
      ++matched;
      if (m.object != m.box) ++wrong;
    }
  }
  EXPECT_GT(matched, 1500);
  EXPECT_LE(wrong, matched / 100);
}

TEST(MatchAcrossCameras, NamesWhatCannotBeMatched) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROWS(MatchAcrossCameras({{0.0, 0.0, nan}}, {}, kSame, kCamera), InvalidArgument,
                "object 0: its centroid is not finite");
  EXPECT_THROWS(MatchAcrossCameras({}, {cv::Rect2d(1, 1, 0, 5)}, kSame, kCamera), InvalidArgument,
                "box 0 of the second camera is 0 x 5 pixels");
  Pose none = Pose::Identity();
  none.translation().x() = nan;
  EXPECT_THROWS(MatchAcrossCameras({}, {}, none, kCamera), InvalidArgument,
                "the pose between the cameras is not finite; calibrate them");
  EXPECT_THROWS(MatchAcrossCameras({}, {}, kSame, {640, 480, 0.0, 0.0, 320.0, 240.0}),
                InvalidArgument,
                "camera 'second': focal lengths fx = 0, fy = 0 px must be positive");
  CrossMatchConfig config;
  config.position_sigma_m = 0.0;
  EXPECT_THROWS(MatchAcrossCameras({}, {}, kSame, kCamera, config), ConfigError,
                "position_sigma_m = 0");
}

}  // namespace
}  // namespace secondlook::fusion
