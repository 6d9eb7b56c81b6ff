#include "lib/kinematics/head.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::kinematics {
namespace {

using Eigen::Vector3d;

TEST(CameraInBase, LooksForwardFromItsHeightWhenTheHeadIsStraight) {
  const Pose X_BC = CameraInBase(HeadCalibration::AtHeight(1.25), {});
  EXPECT_TRUE((X_BC * Vector3d(0, 0, 1)).isApprox(Vector3d(1, 0, 1.25), 1e-12));
  // Right of the camera is -y of the base, down is -z.
  EXPECT_TRUE((X_BC * Vector3d(1, 0, 0)).isApprox(Vector3d(0, -1, 1.25), 1e-12));
  EXPECT_TRUE((X_BC * Vector3d(0, 1, 0)).isApprox(Vector3d(0, 0, 0.25), 1e-12));
}

TEST(CameraInBase, PansToTheLeftAndTiltsDown) {
  const Pose X_BC =
      CameraInBase(HeadCalibration::AtHeight(1.0), {std::numbers::pi / 2, std::numbers::pi / 6});
  const Vector3d ahead = X_BC.linear() * Vector3d::UnitZ();
  EXPECT_TRUE(ahead.isApprox(Vector3d(0, std::cos(std::numbers::pi / 6), -0.5), 1e-12));
}

TEST(AimAt, PutsTheOpticalAxisThroughThePoint) {
  Rng rng(5);
  for (int i = 0; i < 200; ++i) {
    HeadCalibration calibration = HeadCalibration::AtHeight(rng.Uniform(0.5, 1.5));
    calibration.X_HC.translation() << rng.Uniform(-.03, .03), rng.Uniform(-.03, .03), 0.02;
    calibration.X_HC.linear() =
        calibration.X_HC.linear() *
        RotationFromVector({rng.Gaussian(0.01), rng.Gaussian(0.01), rng.Gaussian(0.01)});
    const Vector3d p_BQ(rng.Uniform(0.6, 2.5), rng.Uniform(-2, 2), rng.Uniform(0, 1.2));
    const auto angles = AimAt(calibration, p_BQ);
    ASSERT_TRUE(angles);
    const Vector3d p_CQ = CameraInBase(calibration, *angles).inverse() * p_BQ;
    EXPECT_NEAR(p_CQ.x() / p_CQ.z(), 0.0, 1e-6);
    EXPECT_NEAR(p_CQ.y() / p_CQ.z(), 0.0, 1e-6);
    EXPECT_GT(p_CQ.z(), 0.0);
  }
}

TEST(AimAt, RefusesAPointOnThePanAxis) {
  EXPECT_FALSE(AimAt(HeadCalibration::AtHeight(1.0), {0.01, 0.0, 0.2}));
}

}  // namespace
}  // namespace secondlook::kinematics
