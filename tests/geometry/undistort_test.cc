#include "lib/geometry/undistort.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::geometry {
namespace {

const CameraModel kCamera{160, 120, 140.0, 140.0, 79.5, 59.5};

TEST(LensDistortion, FollowsBrownAndConrady) {
  // By hand at (0.3, 0.4): r2 = 0.25, radial = 1 + 0.1 * 0.25 + 0.2 * 0.0625 + 0.4 * 0.015625.
  const LensDistortion lens{0.1, 0.2, 0.01, 0.02, 0.4};
  const Eigen::Vector2d at = lens.Distort({0.3, 0.4});
  EXPECT_NEAR(at.x(), 0.3 * 1.04375 + 2 * 0.01 * 0.12 + 0.02 * (0.25 + 0.18), 1e-12);
  EXPECT_NEAR(at.y(), 0.4 * 1.04375 + 0.01 * (0.25 + 0.32) + 2 * 0.02 * 0.12, 1e-12);
}

TEST(Undistort, PutsAPointBackWhereAnIdealLensWouldHaveIt) {
  const LensDistortion lens{-0.2, 0.05, 0.0, 0.0, 0.0};
  const Eigen::Vector2d ideal(0.4, -0.3);
  const Eigen::Vector2d seen = lens.Distort(ideal);
  cv::Mat depth(120, 160, CV_32FC1, cv::Scalar(1.0));
  const auto pixel = [](const Eigen::Vector2d& xy) {
    return cv::Point(static_cast<int>(std::lround(xy.x() * 140.0 + 79.5)),
                     static_cast<int>(std::lround(xy.y() * 140.0 + 59.5)));
  };
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      depth.at<float>(pixel(seen) + cv::Point(dx, dy)) = 2.0F;
    }
  }
  const cv::Mat result = Undistort(depth, kCamera, lens);
  EXPECT_EQ(result.at<float>(pixel(ideal)), 2.0F);
  // Depth is never a mixture.
  for (const float z : cv::Mat_<float>(result)) {
    EXPECT_TRUE(std::isnan(z) || z == 1.0F || z == 2.0F);
  }
}

TEST(Undistort, LeavesAnImageWithoutDistortionAlone) {
  const cv::Mat image(120, 160, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(Undistort(image, kCamera, {}).data, image.data);
}

TEST(Undistort, RefusesWhatDoesNotFit) {
  EXPECT_THROWS(Undistort(cv::Mat(100, 160, CV_32FC1), kCamera, {}), InvalidArgument,
                "cannot undistort a 160 x 100 image");
  EXPECT_THROWS(Undistort(cv::Mat(120, 160, CV_16UC1), kCamera, {}), InvalidArgument,
                "cannot undistort");
}

}  // namespace
}  // namespace secondlook::geometry
