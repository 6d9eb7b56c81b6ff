#include "lib/perception/board.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::perception {
namespace {

const geometry::CameraModel kCamera{640, 480, 577.0, 577.0, 319.5, 239.5};
constexpr int kSquarePx = 40;

/// Where the point that lies (x, y) [m] from the upper left corner of the picture is seen, when the
/// board stands 1.2 m before the camera and is turned by 30 degrees about the vertical.
Eigen::Vector2d SeenAt(double x, double y) {
  const Eigen::Vector3d p_C(0.8660254 * x - 0.25, y - 0.2, 1.2 + 0.5 * x);
  return {kCamera.fx * p_C.x() / p_C.z() + kCamera.cx, kCamera.fy * p_C.y() / p_C.z() + kCamera.cy};
}

/// The board of 7 x 5 squares of 8 cm as the camera sees it, on grey.
cv::Mat Seen(const Board& board) {
  const cv::Mat picture = DrawBoard(board, kSquarePx);
  std::vector<cv::Point2f> from;
  std::vector<cv::Point2f> to;
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(7, 0), std::pair(7, 5), std::pair(0, 5)}) {
    from.emplace_back(kSquarePx * x - 0.5F, kSquarePx * y - 0.5F);
    const Eigen::Vector2d at = SeenAt(0.08 * x, 0.08 * y);
    to.emplace_back(static_cast<float>(at.x()), static_cast<float>(at.y()));
  }
  cv::Mat gray(kCamera.height, kCamera.width, CV_8UC1, cv::Scalar(150));
  cv::warpPerspective(picture, gray, cv::getPerspectiveTransform(from, to), gray.size(),
                      cv::INTER_AREA, cv::BORDER_TRANSPARENT);
  cv::Mat color;
  cv::cvtColor(gray, color, cv::COLOR_GRAY2RGB);
  return color;
}

Board Large() { return {7, 5, 0.08, 0.06}; }

TEST(Board, IsFoundWhereItIs) {
  const auto seen = FindBoard(Seen(Large()), kCamera, Large());
  ASSERT_TRUE(seen.has_value());
  ASSERT_GE(seen->corners.size(), 22U);  // of 6 x 4 inner corners
  for (const Eigen::Vector2d& corner : seen->corners) {
    double nearest = 1e9;
    for (int x = 1; x <= 6; ++x) {
      for (int y = 1; y <= 4; ++y) {
        nearest = std::min(nearest, (SeenAt(0.08 * x, 0.08 * y) - corner).norm());
      }
    }
    EXPECT_LT(nearest, 0.25);
  }
}

TEST(Board, IsPlacedWhereItsCornersAre) {
  const auto seen = FindBoard(Seen(Large()), kCamera, Large());
  ASSERT_TRUE(seen.has_value());
  for (std::size_t i = 0; i < seen->corners.size(); ++i) {
    const auto pixel = kCamera.Project(seen->X_CP * seen->points_P[i]);
    ASSERT_TRUE(pixel.has_value());
    EXPECT_LT((*pixel - seen->corners[i]).norm(), 0.5);
    EXPECT_EQ(seen->points_P[i].z(), 0.0);
  }
  EXPECT_NEAR((seen->X_CP * Eigen::Vector3d(0.28, 0.2, 0.0)).z(), 1.34, 0.02);
}

TEST(Board, APartOfItIsEnough) {
  cv::Mat color = Seen(Large());
  color(cv::Rect(0, 0, 320, 480)).setTo(cv::Scalar(150, 150, 150));
  const auto seen = FindBoard(color, kCamera, Large());
  ASSERT_TRUE(seen.has_value());
  EXPECT_GE(seen->corners.size(), 8U);
  EXPECT_LT(seen->corners.size(), 24U);
}

TEST(Board, IsNotFoundWhereThereIsNone) {
  EXPECT_FALSE(FindBoard(cv::Mat(480, 640, CV_8UC3, cv::Scalar(150, 150, 150)), kCamera, Large()));
}

TEST(Board, RefusesSizesThatNoBoardHas) {
  EXPECT_THROWS((Board{2, 5, 0.04, 0.03}.Validate()), ConfigError,
                "'columns' = 2 must lie in 3..14");
  EXPECT_THROWS((Board{7, 5, 40.0, 30.0}.Validate()), ConfigError, "'square' = 40 must lie in");
  EXPECT_THROWS((Board{7, 5, 0.04, 0.04}.Validate()), ConfigError, "'marker' = 0.04 must lie in");
}

}  // namespace
}  // namespace secondlook::perception
