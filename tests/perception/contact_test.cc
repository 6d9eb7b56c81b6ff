#include "lib/perception/contact.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace secondlook::perception {
namespace {

using geometry::PointPlanePair;

/// A brick of 60 x 40 x 20 mm, tilted by a twentieth of a radian about y, that is lifted by 5 mm
/// off the plane z = 0.
class Contact : public ::testing::Test {
 protected:
  Contact() {
    for (const float x : {-0.03F, 0.03F}) {
      for (const float y : {-0.02F, 0.02F}) {
        for (const float z : {0.0F, 0.02F}) brick_.hull.emplace_back(x, y, z);
      }
    }
    X_CM_.linear() = RotationFromVector({0.0, 0.05, 0.0});
    // The edge at x = 0.03 m is the lowest, 1.5 mm under the middle; the other is 1.5 mm above it.
    X_CM_.translation().z() = 0.005 + 0.03 * std::sin(0.05);
    plane_C_.normal_A = Eigen::Vector3d::UnitZ();
  }

  static double Distance(const PointPlanePair& pair) {
    return pair.normal_A.dot(pair.p_AQ - pair.p_AP);
  }

  RecognitionModel brick_;
  Pose X_CM_{Pose::Identity()};
  world::SupportPlane plane_C_;
  std::vector<PointPlanePair> pairs_;
};

TEST_F(Contact, BringsEachOfTheLowestPointsOntoThePlane) {
  AddContact(brick_, X_CM_, plane_C_, 8.0, &pairs_);
  ASSERT_EQ(pairs_.size(), 4U);  // the base
  for (const PointPlanePair& pair : pairs_) {
    EXPECT_NEAR(pair.p_AQ.z(), 0.0, 1e-6);
    EXPECT_DOUBLE_EQ(pair.weight, 2.0);
  }
}

TEST_F(Contact, OfTheHeightMovesThemAllAlike) {
  AddContactHeight(brick_, X_CM_, plane_C_, 8.0, &pairs_);
  ASSERT_EQ(pairs_.size(), 4U);
  for (const PointPlanePair& pair : pairs_) EXPECT_NEAR(Distance(pair), -0.005, 1e-6);
}

TEST_F(Contact, LeavesWhatStandsHighAboveThePlaneAlone) {
  X_CM_.translation().z() += 0.025;
  AddContact(brick_, X_CM_, plane_C_, 8.0, &pairs_);
  AddContactHeight(brick_, X_CM_, plane_C_, 8.0, &pairs_);
  EXPECT_TRUE(pairs_.empty());
}

}  // namespace
}  // namespace secondlook::perception
