#include "lib/common/pose.h"

#include <gtest/gtest.h>

namespace secondlook {
namespace {

using Eigen::Vector3d;

TEST(LookAt, PutsTheTargetOnTheOpticalAxisAndUpIntoTheUpperHalf) {
  const Vector3d p_WC(1.0, -2.0, 1.5);
  const Vector3d p_WT(0.2, 0.3, 0.7);
  const Pose X_WC = LookAt(p_WC, p_WT);
  EXPECT_TRUE(IsValid(X_WC));
  const Vector3d p_CT = X_WC.inverse() * p_WT;
  EXPECT_TRUE(p_CT.isApprox(Vector3d(0.0, 0.0, (p_WT - p_WC).norm()), 1e-12));
  const Vector3d up_C = X_WC.linear().transpose() * Vector3d::UnitZ();
  EXPECT_NEAR(up_C.x(), 0.0, 1e-12);
  EXPECT_LT(up_C.y(), 0.0) << "y is down in a picture";
}

TEST(LookAt, TowardsMinusYHasMinusXOnItsRight) {
  // From the origin towards -y, with z up, the right hand points to -x.
  const Pose X_WC = LookAt(Vector3d::Zero(), Vector3d(0.0, -1.0, 0.0));
  EXPECT_TRUE(X_WC.linear().col(0).isApprox(-Vector3d::UnitX()));
  EXPECT_TRUE(X_WC.linear().col(1).isApprox(-Vector3d::UnitZ()));
}

}  // namespace
}  // namespace secondlook
