#include "lib/perception/own_body.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::perception {
namespace {

using geometry::PlacedShape;

const geometry::CameraModel kCamera{80, 60, 70.0, 70.0, 39.5, 29.5};

PlacedShape At(const geometry::Shape& shape, double x, double y, double z) {
  PlacedShape placed{shape, Pose::Identity()};
  placed.X_AS.translation() << x, y, z;
  return placed;
}

TEST(WithoutOwnBody, TakesOutExactlyWhatLiesWithinTheMargin) {
  Rng rng(6);
  for (int trial = 0; trial < 30; ++trial) {
    std::vector<PlacedShape> body;
    for (int i = 0; i < 3; ++i) {
      PlacedShape part = At(geometry::Cylinder{0.1, 0.5}, rng.Uniform(-1, 1), rng.Uniform(-1, 1),
                            rng.Uniform(-0.3, 2.0));
      part.X_AS.linear() = RotationFromVector({rng.Gaussian(1), rng.Gaussian(1), rng.Gaussian(1)});
      body.push_back(part);
    }
    cv::Mat depth(60, 80, CV_32FC1);
    for (float& z : cv::Mat_<float>(depth)) z = static_cast<float>(rng.Uniform(0.1, 2.2));
    const cv::Mat rest = WithoutOwnBody(depth, kCamera, body, 0.03);
    for (int v = 0; v < 60; ++v) {
      for (int u = 0; u < 80; ++u) {
        const double z = depth.at<float>(v, u);
        const Eigen::Vector3d p_CQ((u - 39.5) / 70.0 * z, (v - 29.5) / 70.0 * z, z);
        bool own = false;
        for (const PlacedShape& part : body) {
          own |= geometry::Distance(part.shape, part.X_AS.inverse() * p_CQ) <= 0.03;
        }
        ASSERT_EQ(std::isnan(rest.at<float>(v, u)), own) << u << ", " << v;
        if (!own) {
          ASSERT_EQ(rest.at<float>(v, u), depth.at<float>(v, u));
        }
      }
    }
  }
}

TEST(WithoutOwnBody, LeavesWhatIsSeenInFrontOfItAndBehind) {
  cv::Mat depth(60, 80, CV_32FC1, cv::Scalar(1.0));
  depth.at<float>(30, 40) = 0.8F;
  depth.at<float>(31, 40) = 1.2F;
  const cv::Mat rest = WithoutOwnBody(depth, kCamera, {At(geometry::Sphere{0.1}, 0, 0, 1.0)}, 0.02);
  EXPECT_EQ(rest.at<float>(30, 40), 0.8F);
  EXPECT_EQ(rest.at<float>(31, 40), 1.2F);
  EXPECT_TRUE(std::isnan(rest.at<float>(30, 41)));
}

TEST(WithoutOwnBody, LeavesTheGivenImageAsItIs) {
  const cv::Mat depth(60, 80, CV_32FC1, cv::Scalar(1.0));
  WithoutOwnBody(depth, kCamera, {At(geometry::Sphere{5.0}, 0, 0, 1.0)}, 0.0);
  EXPECT_EQ(cv::countNonZero(depth == 1.0), 60 * 80);
}

TEST(WithoutOwnBody, TakesACameraWithoutDepth) {
  EXPECT_TRUE(WithoutOwnBody({}, kCamera, {At(geometry::Sphere{1.0}, 0, 0, 1)}, 0.1).empty());
}

TEST(WithoutOwnBody, RefusesWhatDoesNotFitTheCamera) {
  EXPECT_THROWS(WithoutOwnBody(cv::Mat(10, 80, CV_32FC1), kCamera, {}, 0.1), InvalidArgument,
                "a depth image of 80 x 10 pixels for a camera of 80 x 60");
  EXPECT_THROWS(WithoutOwnBody(cv::Mat(60, 80, CV_32FC1), kCamera, {}, -0.1), InvalidArgument,
                "a margin of -0.1 m");
}

}  // namespace
}  // namespace secondlook::perception
