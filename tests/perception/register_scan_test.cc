#include "lib/perception/register_scan.h"

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"
#include "tests/support/scan_of.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kVoxel = 0.002;
const Eigen::AlignedBox3d kBox(Vector3d::Constant(-0.2), Vector3d::Constant(0.2));
const Vector3d kFrom(0.38, -0.25, 0.3);   // sees two sides and the top of a box, as does…
const Vector3d kFirst(0.45, -0.12, 0.3);  // …the first scan
const Vector3d kTarget(0.0, 0.0, 0.05);

world::RangeScan Scan(const geometry::Mesh& mesh, const Vector3d& from) {
  Rng rng(3);
  world::RangeScan scan = tests::ScanOf(mesh, from, kTarget, 140, 0.001, 0.0002, &rng);
  scan.position_sigma = 0.003;
  scan.rotation_sigma = 0.02;
  return scan;
}

/// The surface that a first scan from nearby gave.
world::PartialMesh Surface(const geometry::Mesh& mesh, const Vector3d& from = kFirst) {
  world::SurfaceVolume volume({.voxel_m = kVoxel}, kBox);
  volume.Integrate(Scan(mesh, from));
  return volume.Extract();
}

/// The scan as poses that err by `error` have it.
RegisteredScan Register(const geometry::Mesh& mesh, const Pose& error, const Vector3d& from = kFrom,
                        const Vector3d& first = kFirst) {
  world::RangeScan scan = Scan(mesh, from);
  for (Vector3d& p : scan.points_W) p = error * p;
  scan.lines.front().p_WS = error * scan.lines.front().p_WS;
  world::ScanPatches patches = CutIntoPatches(scan, 2.0 * kVoxel);
  return RegisterScan(std::move(scan), std::move(patches), Surface(mesh, first), kVoxel,
                      ScanRegisterConfig(kVoxel));
}

/// A small turn about the axis z and a shift.
Pose Error(double degrees, const Vector3d& shift) {
  Pose error = Pose::Identity();
  error.linear() = RotationFromVector(Vector3d(0, 0, degrees * 0.0174533));
  error.translation() = shift;
  return error;
}

/// Where the scan's registration leaves the point that truly is `p_W`.
Vector3d Left(const RegisteredScan& registered, const Pose& error, const Vector3d& p_W,
              const Vector3d& from = kFrom) {
  Pose nominal = Pose::Identity();
  nominal.translation() = error * from;
  return registered.registration.X_WC * nominal.inverse() * error * p_W - p_W;
}

TEST(RegisterScan, BringsABoxBackToItsSurface) {
  const geometry::Mesh box = geometry::MakeBox({0.07, 0.08, 0.1}, Vector3f::Constant(0.5F));
  const Pose error = Error(1.0, {0.003, -0.003, 0.002});
  const RegisteredScan registered = Register(box, error);
  ASSERT_TRUE(registered.registration.accepted) << registered.registration.reason;
  EXPECT_EQ(registered.registration.constrained, 6);
  for (const Vector3d& p : {Vector3d(0.035, 0.04, 0.05), Vector3d(0.035, -0.04, -0.05)}) {
    EXPECT_LT(Left(registered, error, p).norm(), 0.0005);
  }
}

TEST(RegisterScan, DoesNotSlideOnACan) {
  // Its side alone: the tin reaches beyond what the sensor sees.
  geometry::Mesh can = geometry::MakeCylinder(0.035, 1.0, 120, Vector3f::Constant(0.5F));
  for (Vector3f& vertex : can.vertices) vertex.z() -= 0.5F;
  const Pose error = Error(2.0, {0.002, 0.003, 0.0});
  // From so far beside the first that much of it lies beyond the surface's border.
  const Vector3d from(0.45, 0.05, 0.3);
  const RegisteredScan registered = Register(can, error, from, {0.4, -0.15, 0.3});
  ASSERT_TRUE(registered.registration.accepted) << registered.registration.reason;
  EXPECT_EQ(registered.registration.constrained, 4);
  const Vector3d middle = Left(registered, error, {0.0, 0.0, 0.05}, from);
  EXPECT_LT(middle.head<2>().norm(), 0.0005);  // held by the side…
  EXPECT_LT(std::abs(middle.z()), 0.0005);  // …not held: where the poses say, and they were right
  const Vector3d front = Left(registered, error, {0.035, 0.0, 0.05}, from);
  EXPECT_NEAR(front.y(), 0.035 * 2.0 * 0.0174533, 0.0006);  // the turn about its axis stays
}

TEST(RegisterScan, RefusesWhatThePosesContradict) {
  const geometry::Mesh box = geometry::MakeBox({0.07, 0.08, 0.1}, Vector3f::Constant(0.5F));
  const Pose error = Error(0.0, {0.3, 0.0, 0.0});
  const RegisteredScan registered = Register(box, error);
  EXPECT_FALSE(registered.registration.accepted);
  EXPECT_THAT(registered.registration.reason, ::testing::HasSubstr("at least 60 pairs"));
  EXPECT_LT((registered.scan.lines.front().p_WS - error * kFrom).norm(), 1e-12);
}

TEST(RegisterScan, NamesWhatIsWrong) {
  const geometry::Mesh box = geometry::MakeBox({0.07, 0.08, 0.1}, Vector3f::Constant(0.5F));
  world::RangeScan scan = Scan(box, kFrom);
  const RegisterConfig config = ScanRegisterConfig(kVoxel);
  const world::ScanPatches patches = CutIntoPatches(scan, 0.004);
  EXPECT_THROWS(RegisterScan(scan, patches, {}, kVoxel, config), InvalidArgument,
                "the surface is empty");
  const world::PartialMesh surface = Surface(box);
  EXPECT_THROWS(RegisterScan({}, {}, surface, kVoxel, config), InvalidArgument, "has no points");
  scan.position_sigma = 0.0;
  EXPECT_THROWS(RegisterScan(scan, patches, surface, kVoxel, config), InvalidArgument,
                "sigmas of 0 m");
}

}  // namespace
}  // namespace secondlook::perception
