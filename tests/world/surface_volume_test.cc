#include "lib/world/surface_volume.h"

#include <array>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"
#include "tests/support/scan_of.h"

namespace secondlook::world {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using Eigen::Vector3f;
using tests::ScanOf;

const AlignedBox3d kBox(Vector3d::Constant(-0.2), Vector3d::Constant(0.2));
constexpr double kRadius = 0.04;
const Vector3f kGrey = Vector3f::Constant(0.5F);

/// Edges that belong to one triangle alone.
int BorderEdges(const geometry::Mesh& mesh) {
  std::map<std::array<int, 2>, int> uses;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k)
      ++uses[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
  }
  int borders = 0;
  for (const auto& [edge, count] : uses) borders += count == 1 ? 1 : 0;
  return borders;
}

double Area(const geometry::Mesh& mesh) {
  double area = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3f a = mesh.vertices[t[0]];
    area += 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
  }
  return area;
}

/// A ball scanned from the six sides.
PartialMesh BallFromAllSides(double sigma) {
  const geometry::Mesh ball = geometry::MakeSphere(kRadius, 200, kGrey);
  SurfaceVolume volume({.voxel_m = 0.002}, kBox);
  Rng rng(1);
  for (const Vector3d& from :
       {Vector3d(0.5, 0, 0.01), Vector3d(-0.5, 0, 0.01), Vector3d(0, 0.5, 0.01),
        Vector3d(0, -0.5, 0.01), Vector3d(0.01, 0, 0.5), Vector3d(0.01, 0, -0.5)}) {
    volume.Integrate(ScanOf(ball, from, Vector3d::Zero(), 120, 0.0008, sigma, &rng));
  }
  return volume.Extract();
}

TEST(SurfaceVolume, ClosesABallThatWasSeenFromAllSides) {
  const PartialMesh surface = BallFromAllSides(0.0);
  EXPECT_EQ(BorderEdges(surface.mesh), 0);
  EXPECT_NEAR(Area(surface.mesh), 4.0 * std::numbers::pi * kRadius * kRadius, 2e-4);
  for (std::size_t i = 0; i < surface.mesh.vertices.size(); ++i) {
    ASSERT_NEAR(surface.mesh.vertices[i].norm(), kRadius, 2e-4);
    ASSERT_GT(surface.normals[i].dot(surface.mesh.vertices[i].normalized()), 0.95F);
  }
  for (const Eigen::Vector3i& t : surface.mesh.triangles) {  // seen from outside
    const Vector3f a = surface.mesh.vertices[t[0]];
    const Vector3f b = surface.mesh.vertices[t[1]];
    const Vector3f c = surface.mesh.vertices[t[2]];
    ASSERT_GE((b - a).cross(c - a).dot(a), 0.0F);
  }
}

TEST(SurfaceVolume, AveragesTheNoiseOfItsScans) {
  const PartialMesh surface = BallFromAllSides(0.001);
  double sum = 0.0;
  for (const Vector3f& p : surface.mesh.vertices) {
    const double off = p.norm() - kRadius;
    sum += off * off;
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(surface.mesh.vertices.size())), 0.0005);
}

TEST(SurfaceVolume, EndsWhereMeasuringEnded) {
  const geometry::Mesh ball = geometry::MakeSphere(kRadius, 200, kGrey);
  SurfaceVolume volume({.voxel_m = 0.002}, kBox);
  Rng rng(1);
  volume.Integrate(ScanOf(ball, {0.0, 0.01, 0.5}, Vector3d::Zero(), 120, 0.0008, 0.0, &rng));
  const PartialMesh surface = volume.Extract();
  EXPECT_GT(BorderEdges(surface.mesh), 50);
  // Of the half that faces the sensor what is seen no flatter than 75 degrees, and a voxel more.
  for (const Vector3f& p : surface.mesh.vertices) {
    ASSERT_GT(p.z(), kRadius * std::cos(76.0 * std::numbers::pi / 180.0) - 0.003);
  }
  EXPECT_TRUE(SurfaceVolume({}, kBox).Extract().mesh.empty());
}

TEST(SurfaceVolume, KeepsWhatLiesInItsBoxAlone) {
  const geometry::Mesh ball = geometry::MakeSphere(kRadius, 100, kGrey);
  Rng rng(1);
  const RangeScan scan = ScanOf(ball, {0.0, 0.01, 0.5}, Vector3d::Zero(), 100, 0.001, 0.0, &rng);
  SurfaceVolume elsewhere({}, AlignedBox3d(Vector3d(1, 1, 1), Vector3d(2, 2, 2)));
  EXPECT_EQ(elsewhere.Integrate(scan), 0);
  EXPECT_EQ(elsewhere.size(), 0);
}

TEST(SurfaceVolume, DensityIsTheShareOfVoxelsThatHoldAPoint) {
  const geometry::Mesh plate = geometry::MakeBox({0.1, 0.1, 0.01}, kGrey);
  Rng rng(1);
  const auto mean_density = [&](double spacing) {
    SurfaceVolume volume({.voxel_m = 0.002, .min_points = 1}, kBox);
    volume.Integrate(ScanOf(plate, {0.0, 0.01, 0.5}, {0, 0, 0.005},
                            static_cast<int>(0.08 / spacing), spacing, 0.0, &rng));
    const PartialMesh surface = volume.Extract();
    double sum = 0.0;
    int inner = 0;
    for (std::size_t i = 0; i < surface.density.size(); ++i) {
      if (surface.mesh.vertices[i].head<2>().lpNorm<Eigen::Infinity>() > 0.03F) continue;
      sum += surface.density[i];
      ++inner;
    }
    return sum / inner;
  };
  EXPECT_GT(mean_density(0.0005), 0.9);
  EXPECT_NEAR(mean_density(0.003), 4.0 / 9.0, 0.12);  // a point on 9 mm^2, a voxel's face is 4 mm^2
}

TEST(SurfaceVolume, CarriesTheColoursOfItsScans) {
  const geometry::Mesh ball = geometry::MakeSphere(kRadius, 100, kGrey);
  Rng rng(1);
  RangeScan scan = ScanOf(ball, {0.0, 0.01, 0.5}, Vector3d::Zero(), 100, 0.001, 0.0, &rng);
  scan.colors.assign(scan.points_W.size(), Vector3f(0.9F, 0.2F, 0.1F));
  SurfaceVolume volume({}, kBox);
  volume.Integrate(scan);
  const PartialMesh surface = volume.Extract();
  ASSERT_EQ(surface.mesh.vertex_colors.size(), surface.mesh.vertices.size());
  for (const Vector3f& color : surface.mesh.vertex_colors) {
    ASSERT_LT((color - Vector3f(0.9F, 0.2F, 0.1F)).norm(), 1e-4F);
  }
}

TEST(SurfaceVolume, NamesWhatIsWrong) {
  EXPECT_THROWS(SurfaceVolume({.voxel_m = 0.0}, kBox), ConfigError, "voxel_m = 0 must lie in");
  EXPECT_THROWS(SurfaceVolume({}, AlignedBox3d()), InvalidArgument, "is empty");
  RangeScan scan;
  scan.points_W = {Vector3d::Zero()};
  scan.sigmas = {0.001F};
  scan.lines = {{Vector3d(0, 0, 1), 1}};
  SurfaceVolume volume({}, kBox);
  EXPECT_THROWS(volume.Integrate(scan, {}), InvalidArgument, "patches of 0 points for a scan of 1");
}

TEST(ScanPatches, AWiresNormalIsUprightOnItTowardsTheSensor) {
  RangeScan scan;
  for (int i = 0; i < 100; ++i) scan.points_W.emplace_back(0.001 * i, 0.0013, 0.0013);
  scan.sigmas.assign(100, 1e-4F);
  scan.lines = {{Vector3d(0.3, 0.0013, 0.5), 100}};
  for (const ScanPatch& patch : CutIntoPatches(scan, 0.01).patches) {
    EXPECT_NEAR(patch.normal_W.z(), 1.0, 1e-6);
  }
  EXPECT_THROWS(CutIntoPatches(scan, 0.0), InvalidArgument, "patches of 0 m");
}

}  // namespace
}  // namespace secondlook::world
