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

}  // namespace
}  // namespace secondlook::perception
