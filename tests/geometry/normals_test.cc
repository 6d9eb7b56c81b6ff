#include "lib/geometry/normals.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/rng.h"
#include "lib/geometry/point_image.h"

namespace secondlook::geometry {
namespace {

const CameraModel kCamera{200, 160, 577.0, 577.0, 99.5, 79.5};

/// The depth of the plane normal . p = offset.
cv::Mat PlaneDepth(const Eigen::Vector3d& normal, double offset) {
  cv::Mat depth(kCamera.height, kCamera.width, CV_32FC1);
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      depth.at<float>(y, x) = static_cast<float>(offset / normal.dot(kCamera.Ray(x, y)));
    }
  }
  return depth;
}

constexpr int kMiddle = 80 * 200 + 100;

TEST(FitLocalPlane, GivesThePlaneItIsOnExactlyWithoutNoise) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    const Eigen::Vector3d normal =
        Eigen::Vector3d(rng.Uniform(-0.7, 0.7), rng.Uniform(-0.7, 0.7), -1.0).normalized();
    const auto point = FitLocalPlane(PlaneDepth(normal, -0.9), {}, kCamera, kMiddle);
    ASSERT_TRUE(point.has_value());
    EXPECT_LT((point->normal.cast<double>() - normal).norm(), 2e-3) << "seed " << seed;
    EXPECT_NEAR(normal.dot(point->point.cast<double>()), -0.9, 1e-4);
  }
}

TEST(FitLocalPlane, KeepsTheNormalWithinAFewDegreesUnderTheSensorsNoise) {
  Rng rng(1);
  double worst = 0.0;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d normal =
        Eigen::Vector3d(rng.Uniform(-0.5, 0.5), rng.Uniform(-0.5, 0.5), -1.0).normalized();
    cv::Mat depth = PlaneDepth(normal, -1.2);
    for (int y = 0; y < depth.rows; ++y) {
      for (int x = 0; x < depth.cols; ++x) {
        float& z = depth.at<float>(y, x);
        z += static_cast<float>(rng.Gaussian(DepthSigma(z)));
      }
    }
    const auto point = FitLocalPlane(depth, {}, kCamera, kMiddle);
    ASSERT_TRUE(point.has_value());
    worst = std::max(worst, std::acos(std::min(1.0, point->normal.cast<double>().dot(normal))));
  }
  EXPECT_LT(worst, 0.16);
}

TEST(FitLocalPlane, DoesNotLookAcrossAnEdge) {
  cv::Mat depth = PlaneDepth({0, 0, -1}, -1.0);
  depth.colRange(102, 200).setTo(1.2F);
  const auto point = FitLocalPlane(depth, {}, kCamera, kMiddle);
  ASSERT_TRUE(point.has_value());
  EXPECT_LT((point->normal - Eigen::Vector3f(0, 0, -1)).norm(), 1e-3F);
}

TEST(FitLocalPlane, StaysWithinItsLabel) {
  // A roof: two slopes that meet at the middle; by depth alone they could not be told apart.
  cv::Mat depth(kCamera.height, kCamera.width, CV_32FC1);
  cv::Mat labels(depth.size(), CV_32SC1);
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      labels.at<int>(y, x) = x <= 100 ? 0 : 1;
      depth.at<float>(y, x) = static_cast<float>(1.0 + 0.001 * std::abs(x - 100));
    }
  }
  const auto alone = FitLocalPlane(depth, labels, kCamera, kMiddle);
  const auto mixed = FitLocalPlane(depth, {}, kCamera, kMiddle);
  ASSERT_TRUE(alone.has_value() && mixed.has_value());
  EXPECT_GT(std::abs(alone->normal.x()), 0.3F);
  EXPECT_LT(std::abs(mixed->normal.x()), 0.05F);
}

TEST(FitLocalPlane, IsEmptyWhereNothingOrTooLittleIsMeasured) {
  cv::Mat depth = PlaneDepth({0, 0, -1}, -1.0);
  depth.at<float>(80, 100) = NAN;
  EXPECT_FALSE(FitLocalPlane(depth, {}, kCamera, kMiddle).has_value());
  cv::Mat lonely(depth.size(), CV_32FC1, cv::Scalar(NAN));
  lonely.at<float>(80, 100) = 1.0F;
  lonely.at<float>(80, 101) = 1.0F;
  EXPECT_FALSE(FitLocalPlane(lonely, {}, kCamera, kMiddle).has_value());
}

}  // namespace
}  // namespace secondlook::geometry
