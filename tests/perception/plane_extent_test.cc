#include "lib/perception/plane_extent.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;
using testing::DoubleNear;

const Vector3d kUp(0.0, 0.0, 1.0);

/// A grid of points at height 0.7, `step` apart, from (x, y) on.
std::vector<Vector3d> Grid(double x, double y, int columns, int rows, double step) {
  std::vector<Vector3d> points;
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) points.emplace_back(x + step * i, y + step * j, 0.7);
  }
  return points;
}

TEST(PlaneAxes, AreUnitAndSpanThePlane) {
  for (const Vector3d& normal : {Vector3d(0, 0, 1), Vector3d(1, 2, -2), Vector3d(-3, 0.1, 0)}) {
    const Vector3d n = normal.normalized();
    const auto axes = PlaneAxes(n);
    EXPECT_NEAR(axes[0].norm(), 1.0, 1e-12);
    EXPECT_NEAR(axes[0].dot(n), 0.0, 1e-12);
    EXPECT_LT((axes[0].cross(axes[1]) - n).norm(), 1e-12);
  }
}

TEST(FitRectangle, OfATurnedRectangleHasItsSides) {
  std::vector<Vector3d> points;
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  for (const Vector3d& p : Grid(0.0, 0.0, 11, 6, 0.1)) {
    points.emplace_back(c * p.x() - s * p.y(), s * p.x() + c * p.y(), p.z());
  }
  const auto corners = FitRectangle(points, kUp, 0.7);
  const double a = (corners[1] - corners[0]).norm();
  const double b = (corners[2] - corners[1]).norm();
  EXPECT_NEAR(std::max(a, b), 1.0, 1e-4);
  EXPECT_NEAR(std::min(a, b), 0.5, 1e-4);
  EXPECT_GT((corners[1] - corners[0]).cross(corners[2] - corners[1]).z(), 0.0);
  for (const Vector3d& corner : corners) EXPECT_NEAR(corner.z(), 0.7, 1e-6);
}

TEST(FitRectangle, WithoutPointsIsThePointOfThePlaneAtTheOrigin) {
  for (const Vector3d& corner : FitRectangle({}, kUp, 0.7)) {
    EXPECT_EQ(corner, Vector3d(0.0, 0.0, 0.7));
  }
}

TEST(LargestPatch, LeavesOutWhatLiesApart) {
  std::vector<Vector3d> points = Grid(0.0, 0.0, 30, 20, 0.01);
  const std::vector<Vector3d> apart = Grid(0.5, 0.0, 10, 10, 0.01);
  points.insert(points.end(), apart.begin(), apart.end());
  EXPECT_EQ(LargestPatch(points, kUp), Grid(0.0, 0.0, 30, 20, 0.01));
}

TEST(ThinnedOnPlane, KeepsOnePointOfEachCell) {
  EXPECT_EQ(ThinnedOnPlane(Grid(0.001, 0.001, 40, 20, 0.005), kUp, 0.02).size(), 50U);
}

TEST(ConvexExtent, OfASquareWithAHoleIsTheSquare) {
  std::vector<Vector3d> points = Grid(0.0, 0.0, 11, 11, 0.1);
  std::erase_if(points, [](const Vector3d& p) {
    return std::abs(p.x() - 0.5) < 0.25 && std::abs(p.y() - 0.5) < 0.25;
  });
  EXPECT_THAT(cv::contourArea(ConvexExtent(points, PlaneAxes(kUp))), DoubleNear(1.0, 1e-6));
}

}  // namespace
}  // namespace secondlook::perception
