#include "lib/perception/seen_through.h"

#include <limits>

#include <gtest/gtest.h>

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;

TEST(ComparePoints, TellsWhatIsThereFromWhatIsSeenThrough) {
  const geometry::CameraModel camera{64, 48, 60.0, 60.0, 31.5, 23.5};
  // A wall 1 m away in the left half of the picture, nothing in the right; W is C.
  cv::Mat depth(48, 64, CV_32F, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  depth.colRange(0, 32) = 1.0F;
  const std::vector<Vector3d> on_it{{-0.2, 0.0, 1.005}, {-0.3, 0.1, 0.99}};
  const std::vector<Vector3d> before_it{{-0.2, 0.0, 0.9}, {-0.1, 0.1, 0.8}, {-0.1, 0.0, 0.96}};
  const std::vector<Vector3d> silent{
      {-0.2, 0.0, 1.2},   // behind it
      {0.2, 0.0, 0.9},    // where nothing is measured
      {-0.2, 0.0, -1.0},  // behind the camera
      {-2.0, 0.0, 1.0},   // out of the picture
      {-0.2, 0.0, 0.98},  // neither on it nor clearly before it
  };
  std::vector<Vector3d> points_W = on_it;
  points_W.insert(points_W.end(), before_it.begin(), before_it.end());
  points_W.insert(points_W.end(), silent.begin(), silent.end());
  const SurfaceAgreement all = ComparePoints(points_W, Pose::Identity(), depth, camera);
  EXPECT_EQ(all.matching, 2);
  EXPECT_EQ(all.see_through, 3);
}

TEST(ComparePoints, DoesNotSeeThroughAWireThatItMissesByAFewMillimetres) {
  const geometry::CameraModel camera{640, 480, 577.0, 577.0, 319.5, 239.5};
  cv::Mat depth(480, 640, CV_32F, cv::Scalar(1.2));
  depth.colRange(320, 322) = 1.0F;  // an upright wire of 3 mm
  std::vector<Vector3d> points_W;
  for (int i = 0; i < 10; ++i) points_W.emplace_back(0.006, 0.01 * i, 1.0);  // 6 mm beside it
  const SurfaceAgreement near = ComparePoints(points_W, Pose::Identity(), depth, camera);
  EXPECT_EQ(near.matching, 10);
  EXPECT_EQ(near.see_through, 0);
  for (Vector3d& p : points_W) p.x() = 0.02;
  EXPECT_EQ(ComparePoints(points_W, Pose::Identity(), depth, camera).see_through, 10);
}

}  // namespace
}  // namespace secondlook::perception
