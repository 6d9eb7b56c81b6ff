#include "lib/perception/striped_scan.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::perception {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Three rays: 45 degrees to the left, ahead, 45 degrees to the right.
hal::StriperInfo Striper() { return {"striper", 3, M_PI / 2, 0.3, 0.6, 50.0, 0.0001}; }

/// The laser looks down from 1 m and goes along y_W by 0.1 m a second, from 1 s to 2 s. Its x axis
/// is that of W.
PoseHistory Downward() {
  PoseHistory X_WL("X_WL", Seconds(10));
  for (const double t : {1.0, 1.5, 2.0}) {
    Pose X = Pose::Identity();
    X.linear() = RotationFromRollPitchYaw(M_PI, 0.0, 0.0);
    X.translation() = Eigen::Vector3d(0.0, 0.1 * (t - 1.0), 1.0);
    X_WL.Add(Time(Seconds(t)), X);
  }
  return X_WL;
}

TEST(StripedScan, PutsEachLineWhereTheLaserWasAtItsTime) {
  const std::vector<hal::ScanLine> lines = {
      {Time(Seconds(1.0)), 7, {kNone, 0.5F, 0.5F}},
      {Time(Seconds(1.25)), 8, {kNone, kNone, kNone}},
      {Time(Seconds(1.75)), 9, {0.5F, kNone, kNone}},
  };
  const world::RangeScan scan = StripedScan(lines, Striper(), Downward(), {0.002, 0.003});
  ASSERT_EQ(scan.points_W.size(), 3U);
  const double side = 0.5 * std::sqrt(0.5);
  EXPECT_TRUE(scan.points_W[0].isApprox(Eigen::Vector3d(0.0, 0.0, 0.5), 1e-6));
  EXPECT_TRUE(scan.points_W[1].isApprox(Eigen::Vector3d(side, 0.0, 1.0 - side), 1e-6));
  EXPECT_TRUE(scan.points_W[2].isApprox(Eigen::Vector3d(-side, 0.075, 1.0 - side), 1e-6));
  ASSERT_EQ(scan.lines.size(), 3U);
  EXPECT_EQ(scan.lines[0].end, 2);
  EXPECT_EQ(scan.lines[1].end, 2);
  EXPECT_EQ(scan.lines[2].end, 3);
  EXPECT_TRUE(scan.lines[1].p_WS.isApprox(Eigen::Vector3d(0.0, 0.025, 1.0), 1e-9));
  EXPECT_FLOAT_EQ(scan.sigmas[0], 0.0001F);
  EXPECT_EQ(scan.position_sigma, 0.002);
  EXPECT_EQ(scan.rotation_sigma, 0.003);
  EXPECT_NO_THROW(world::Check(scan));
}

TEST(StripedScan, RefusesALineFromBeforeOrAfterItsPoses) {
  const std::vector<hal::ScanLine> early = {{Time(Seconds(0.99)), 1, {0.5F, 0.5F, 0.5F}}};
  EXPECT_THROWS(StripedScan(early, Striper(), Downward()), InvalidArgument,
                "asked for 0.990 s, but it covers 1.000 s to 2.000 s; poses are not extrapolated");
  const std::vector<hal::ScanLine> late = {{Time(Seconds(2.01)), 1, {0.5F, 0.5F, 0.5F}}};
  EXPECT_THROWS(StripedScan(late, Striper(), Downward()), InvalidArgument, "not extrapolated");
}

TEST(StripedScan, RefusesALineOfAnotherStriper) {
  const std::vector<hal::ScanLine> lines = {{Time(Seconds(1.0)), 4, {0.5F, 0.5F}}};
  EXPECT_THROWS(StripedScan(lines, Striper(), Downward()), InvalidArgument,
                "striper 'striper': line 4 has 2 ranges for 3 rays");
}

}  // namespace
}  // namespace secondlook::perception
