#include "apps/experiments/pose_error.h"

#include <numbers>

#include <gtest/gtest.h>

namespace secondlook::apps {
namespace {

const geometry::Mesh kBox = geometry::MakeBox({0.2, 0.1, 0.06}, {0.5F, 0.5F, 0.5F});

TEST(PoseErrorMetric, AShiftMovesEveryPointByItself) {
  Pose X_CM = Pose::Identity();
  X_CM.translation().z() = 1.0;
  Pose X_shifted = X_CM;
  X_shifted.translation().x() += 0.012;
  const PoseError error = PoseErrorMetric(kBox).Of(X_shifted, X_CM);
  EXPECT_NEAR(error.add, 0.012, 1e-9);
  EXPECT_LT(error.adds, 0.012);
  EXPECT_GT(error.adds, 0.002);
}

TEST(PoseErrorMetric, AHalfTurnOfABoxIsNoErrorOfItsShape) {
  Pose X_turned = Pose::Identity();
  X_turned.linear() =
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const PoseError error = PoseErrorMetric(kBox).Of(X_turned, Pose::Identity());
  EXPECT_LT(error.adds, 0.001);
  EXPECT_GT(error.add, 0.1);
}

}  // namespace
}  // namespace secondlook::apps
