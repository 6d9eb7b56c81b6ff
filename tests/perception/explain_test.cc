#include "lib/perception/explain.h"

#include <limits>

#include <gtest/gtest.h>

namespace secondlook::perception {
namespace {

const geometry::CameraModel kCamera{64, 48, 60.0, 60.0, 31.5, 23.5};

Pose InFront(double x, double z) {
  Pose X_CM = Pose::Identity();
  X_CM.translation() << x, 0.0, z;
  return X_CM;
}

/// The depth of a wall 1 m away in columns [from, to), NaN elsewhere, and its pixels.
std::pair<cv::Mat, std::vector<int>> Wall(int from, int to) {
  cv::Mat depth(48, 64, CV_32F, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  std::vector<int> pixels;
  for (int v = 10; v < 38; ++v) {
    for (int u = from; u < to; ++u) {
      depth.at<float>(v, u) = 1.0F;
      pixels.push_back(v * 64 + u);
    }
  }
  return {depth, pixels};
}

TEST(TakeExplained, LeavesWhatStandsBesideTheKnownThing) {
  const auto [depth, pixels] = Wall(10, 54);
  std::vector<world::Cluster> clusters{MakeCluster(pixels, depth, kCamera)};
  // A box whose front is 1 m away and covers columns 32 to 62 and all rows.
  const geometry::Mesh box = geometry::MakeBox({0.5, 1.0, 0.2}, {1, 1, 1});
  const world::Cluster taken =
      TakeExplained(box, InFront(0.26, 1.1), depth, kCamera, 50, &clusters);
  ASSERT_EQ(clusters.size(), 1U);
  EXPECT_EQ(clusters[0].pixels.size() + taken.pixels.size(), pixels.size());
  EXPECT_NEAR(static_cast<double>(taken.pixels.size()), 28 * 25, 28 * 3);
  for (const int pixel : clusters[0].pixels) EXPECT_LT(pixel % 64, 32);
}

TEST(TakeExplained, DropsARestThatIsTooSmallToBeAnything) {
  const auto [depth, pixels] = Wall(28, 54);
  std::vector<world::Cluster> clusters{MakeCluster(pixels, depth, kCamera)};
  const geometry::Mesh box = geometry::MakeBox({0.5, 1.0, 0.2}, {1, 1, 1});
  TakeExplained(box, InFront(0.26, 1.1), depth, kCamera, 200, &clusters);
  EXPECT_TRUE(clusters.empty());
}

TEST(TakeExplained, TakesNothingMeasuredElsewhere) {
  const auto [depth, pixels] = Wall(10, 54);
  std::vector<world::Cluster> clusters{MakeCluster(pixels, depth, kCamera)};
  const geometry::Mesh box = geometry::MakeBox({0.5, 1.0, 0.2}, {1, 1, 1});
  EXPECT_TRUE(TakeExplained(box, InFront(0.26, 1.2), depth, kCamera, 50, &clusters).pixels.empty());
  EXPECT_EQ(clusters[0].pixels, pixels);
}

TEST(CompareSurface, TellsWhatIsThereFromWhatIsSeenThrough) {
  const auto [depth, pixels] = Wall(10, 54);
  const geometry::Mesh box = geometry::MakeBox({0.2, 0.2, 0.2}, {1, 1, 1});
  // The front of a box of 0.2 m covers 12 x 12 pixels at 1 m.
  const SurfaceAgreement there = CompareSurface(box, InFront(0.0, 1.1), depth, kCamera);
  EXPECT_NEAR(there.matching, 144, 15);
  EXPECT_EQ(there.see_through, 0);
  const SurfaceAgreement nearer = CompareSurface(box, InFront(0.0, 1.0), depth, kCamera);
  EXPECT_EQ(nearer.matching, 0);
  EXPECT_GT(nearer.see_through, 144);
  const SurfaceAgreement hidden = CompareSurface(box, InFront(0.0, 1.3), depth, kCamera);
  EXPECT_EQ(hidden.matching + hidden.see_through, 0);
}

}  // namespace
}  // namespace secondlook::perception
