#include "lib/fusion/pose_fusion.h"

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::fusion {
namespace {

PoseEstimate Estimate(double yaw, double x, double information) {
  PoseEstimate estimate;
  estimate.X_WM = ToPose(Pose2{x, 0.0, yaw});
  estimate.information *= information;
  return estimate;
}

TEST(FusePoses, WeighsByInformation) {
  const FusedPose fused = FusePoses({Estimate(0.0, 0.0, 3e6), Estimate(0.4, 0.8, 1e6)});
  EXPECT_NEAR(ToPose2(fused.X_WM).yaw, 0.1, 1e-6);
  EXPECT_NEAR(ToPose2(fused.X_WM).x, 0.2, 1e-6);
  EXPECT_NEAR(fused.covariance(0, 0), 1.0 / 4e6, 1e-9);
}

TEST(FusePoses, DoesNotDependOnTheOrder) {
  Rng rng(4);
  std::vector<PoseEstimate> estimates;
  for (int i = 0; i < 5; ++i) {
    PoseEstimate e;
    e.X_WM.linear() =
        RotationFromVector({rng.Uniform(-.2, .2), rng.Uniform(-.2, .2), rng.Uniform(-.2, .2)});
    e.X_WM.translation() << rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1);
    e.information *= rng.Uniform(10.0, 1000.0);
    estimates.push_back(e);
  }
  const FusedPose forward = FusePoses(estimates);
  const FusedPose backward = FusePoses({estimates.rbegin(), estimates.rend()});
  EXPECT_TRUE(forward.X_WM.isApprox(backward.X_WM, 1e-9));
}

TEST(FusePoses, TakesADirectionFromTheViewThatHoldsIt) {
  PoseEstimate first = Estimate(0.0, 0.0, 1e6);
  first.information(3, 3) = 0.0;  // x is open
  PoseEstimate second = Estimate(0.0, 0.05, 1e6);
  second.X_WM.translation().y() = 0.01;
  second.information(4, 4) = 0.0;  // y is open
  const FusedPose fused = FusePoses({first, second});
  EXPECT_NEAR(fused.X_WM.translation().x(), 0.05, 1e-5);
  EXPECT_NEAR(fused.X_WM.translation().y(), 0.0, 1e-5);
}

TEST(LargestCluster, GoesFromNeighbourToNeighbour) {
  // Two chains and a loner; neighbours are less than 1.5 apart.
  const std::vector<double> at{0.0, 10.0, 1.0, 11.0, 2.0, 50.0, 3.0};
  const auto near = [&](int a, int b) { return std::abs(at[a] - at[b]) < 1.5; };
  EXPECT_EQ(LargestCluster(7, near), (std::vector<int>{0, 2, 4, 6}));
  EXPECT_EQ(LargestCluster(4, near), (std::vector<int>{0, 2})) << "of two as large, the first";
  EXPECT_EQ(LargestCluster(0, near), std::vector<int>{});
}

TEST(FusePoses, RefusesNothingAndNonsense) {
  EXPECT_THROWS(FusePoses({}), InvalidArgument, "no pose to fuse");
  PoseEstimate broken;
  broken.X_WM.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROWS(FusePoses({broken}), InvalidArgument, "not a rigid transform");
}

}  // namespace
}  // namespace secondlook::fusion
