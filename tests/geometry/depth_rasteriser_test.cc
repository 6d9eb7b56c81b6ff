#include "lib/geometry/depth_rasteriser.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::geometry {
namespace {

const CameraModel kCamera{160, 120, 140.0, 140.0, 79.5, 59.5};
const PixelRect kWhole{0, 0, 160, 120};

Pose RandomPose(Rng* rng, double distance) {
  Pose X = Pose::Identity();
  X.linear() = RotationFromVector({rng->Uniform(-3, 3), rng->Uniform(-3, 3), rng->Uniform(-3, 3)});
  X.translation() = Eigen::Vector3d(rng->Uniform(-0.1, 0.1), rng->Uniform(-0.1, 0.1), distance);
  return X;
}

Mesh OneTriangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  Mesh mesh;
  mesh.vertices = {a, b, c};
  mesh.triangles = {{0, 1, 2}};
  mesh.triangle_material = {0};
  mesh.materials.resize(1);
  return mesh;
}

/// The nearest hit beyond 1 cm of the ray (x, y, 1) with every triangle (Moeller and Trumbore),
/// in double: the second method.
double CastRay(const Mesh& mesh, const Pose& X_CM, const Eigen::Vector3d& ray) {
  double nearest = INFINITY;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d a = X_CM * mesh.vertices[t[0]].cast<double>();
    const Eigen::Vector3d ab = X_CM * mesh.vertices[t[1]].cast<double>() - a;
    const Eigen::Vector3d ac = X_CM * mesh.vertices[t[2]].cast<double>() - a;
    const Eigen::Vector3d p = ray.cross(ac);
    const double determinant = ab.dot(p);
    if (std::abs(determinant) < 1e-15) continue;
    const double u = -a.dot(p) / determinant;
    const Eigen::Vector3d q = (-a).cross(ab);
    const double v = ray.dot(q) / determinant;
    const double z = ac.dot(q) / determinant;
    if (u < 0 || v < 0 || u + v > 1 || z < 0.01) continue;
    nearest = std::min(nearest, z);
  }
  return nearest;
}

/// A mesh of loose triangles, crossing each other.
Mesh TriangleSoup(Rng* rng, int count, double size) {
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) {
      mesh.vertices.emplace_back(rng->Uniform(-size, size), rng->Uniform(-size, size),
                                 rng->Uniform(-size, size));
    }
    mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  mesh.materials.resize(1);
  return mesh;
}

TEST(DepthRasteriser, ShowsWhatTheRayThroughEachPixelCentreMeets) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Rng rng(seed);
    const Mesh mesh = TriangleSoup(&rng, 20, 0.3);
    const Pose X_CM = RandomPose(&rng, 0.8);
    DepthRasteriser rasteriser;
    rasteriser.Render(mesh, X_CM, kCamera, kWhole);
    int differ = 0;
    for (int i = 0; i < kWhole.area(); ++i) {
      const double z = CastRay(mesh, X_CM, kCamera.Ray(i % 160, i / 160));
      const float drawn = rasteriser.depth()[i];
      if (std::isinf(z) != std::isnan(drawn)) {
        ++differ;
      } else if (!std::isinf(z)) {
        differ += std::abs(z - drawn) > 2e-4 ? 1 : 0;
      }
    }
    EXPECT_LE(differ, 10) << "seed " << seed;  // pixel centres on an edge, to rounding
  }
}

TEST(DepthRasteriser, ClipsTrianglesThatReachBehindTheCamera) {
  for (std::uint64_t seed = 100; seed < 110; ++seed) {
    Rng rng(seed);
    const Mesh mesh = TriangleSoup(&rng, 10, 0.5);
    const Pose X_CM = RandomPose(&rng, 0.1);
    DepthRasteriser rasteriser;
    rasteriser.Render(mesh, X_CM, kCamera, kWhole);
    int differ = 0;
    int drawn = 0;
    for (int i = 0; i < kWhole.area(); ++i) {
      const double z = CastRay(mesh, X_CM, kCamera.Ray(i % 160, i / 160));
      const double got = rasteriser.depth()[i];
      drawn += std::isnan(got) ? 0 : 1;
      const bool same = std::isinf(z) ? std::isnan(got) : std::abs(z - got) < 1e-3 + 2e-3 * z;
      differ += same ? 0 : 1;
    }
    EXPECT_GT(drawn, 1000);
    EXPECT_LE(differ, 30) << "seed " << seed;
  }
}

TEST(DepthRasteriser, DrawsAPlaneAtItsAnalyticDepth) {
  // z = 1 + 0.5 x, seen by every pixel: z = 1 / (1 - 0.5 ray.x).
  const Mesh mesh = OneTriangle({-5, -20, 1 - 2.5F}, {1.9F, 0, 1.95F}, {-5, 20, 1 - 2.5F});
  DepthRasteriser rasteriser;
  rasteriser.Render(mesh, Pose::Identity(), kCamera, kWhole);
  for (int i = 0; i < kWhole.area(); ++i) {
    const Eigen::Vector3d ray = kCamera.Ray(i % 160, i / 160);
    ASSERT_NEAR(rasteriser.depth()[i], 1.0 / (1.0 - 0.5 * ray.x()), 1e-4) << "pixel " << i;
  }
}

TEST(DepthRasteriser, LeavesNoHoleInAMeshWhoseTrianglesAreSmallerThanPixels) {
  const Mesh mesh = MakeSphere(0.1, 40, {0.5F, 0.5F, 0.5F});
  const CameraModel camera{40, 40, 60.0, 60.0, 19.5, 19.5};
  Rng rng(11);
  DepthRasteriser rasteriser;
  for (int i = 0; i < 3; ++i) {
    Pose X_CM = RandomPose(&rng, 0.5);
    X_CM.translation().head<2>() *= 0.5;
    rasteriser.Render(mesh, X_CM, camera, {0, 0, 40, 40});
    int differ = 0;
    for (int k = 0; k < 1600; ++k) {
      const double z = CastRay(mesh, X_CM, camera.Ray(k % 40, k / 40));
      const float drawn = rasteriser.depth()[k];
      const bool same = std::isinf(z) ? std::isnan(drawn) : std::abs(z - drawn) < 2e-4;
      differ += same ? 0 : 1;
    }
    EXPECT_LE(differ, 2);  // pixel centres on the outline, to rounding
  }
}

TEST(DepthRasteriser, DrawsNothingOfATriangleWithAVertexThatIsNoNumber) {
  Mesh mesh = OneTriangle({-1, -1, 1}, {1, -1, 1}, {0, 1, 1});
  mesh.vertices.emplace_back(std::nanf(""), 0.0F, 1.0F);
  DepthRasteriser rasteriser;
  rasteriser.Render(mesh, Pose::Identity(), kCamera, kWhole);
  const std::vector<int> without = rasteriser.triangle();
  mesh.triangles.emplace_back(0, 1, 3);
  rasteriser.Render(mesh, Pose::Identity(), kCamera, kWhole);
  EXPECT_EQ(rasteriser.triangle(), without);
  EXPECT_EQ(rasteriser.triangle()[60 * 160 + 80], 0);
}

TEST(DepthRasteriser, AWindowShowsTheSameAsThatPartOfTheWholeImage) {
  Rng rng(3);
  const Mesh mesh = TriangleSoup(&rng, 30, 0.3);
  const Pose X_CM = RandomPose(&rng, 0.8);
  DepthRasteriser whole;
  DepthRasteriser part;
  whole.Render(mesh, X_CM, kCamera, kWhole);
  part.Render(mesh, X_CM, kCamera, {40, 30, 70, 50});
  int differ = 0;
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 70; ++x) {
      differ += part.triangle()[y * 70 + x] != whole.triangle()[(y + 30) * 160 + x + 40] ? 1 : 0;
    }
  }
  EXPECT_LE(differ, 3);
}

TEST(DepthRasteriser, WeightsGiveThePointOfTheSurfaceOnTheRay) {
  Rng rng(5);
  const Mesh mesh = TriangleSoup(&rng, 5, 0.3);
  const Pose X_CM = RandomPose(&rng, 0.9);
  DepthRasteriser rasteriser;
  rasteriser.Render(mesh, X_CM, kCamera, kWhole);
  int seen = 0;
  for (int i = 0; i < kWhole.area(); ++i) {
    if (rasteriser.triangle()[i] < 0) continue;
    ++seen;
    const Eigen::Vector3i& t = mesh.triangles[rasteriser.triangle()[i]];
    const Eigen::Vector3f w = rasteriser.Weights(mesh, i);
    const Eigen::Vector3d p_C = X_CM * (w[0] * mesh.vertices[t[0]] + w[1] * mesh.vertices[t[1]] +
                                        w[2] * mesh.vertices[t[2]])
                                           .cast<double>();
    const auto pixel = kCamera.Project(p_C);
    ASSERT_TRUE(pixel.has_value());
    ASSERT_NEAR(pixel->x(), i % 160, 0.02);
    ASSERT_NEAR(pixel->y(), i / 160, 0.02);
  }
  EXPECT_GT(seen, 500);
}

TEST(DepthRasteriser, NormalsFaceTheCameraWhicheverWayTheTriangleWinds) {
  const Mesh one = OneTriangle({-1, -1, 1}, {1, -1, 1}, {0, 1, 1});
  const Mesh other = OneTriangle({-1, -1, 1}, {0, 1, 1}, {1, -1, 1});
  DepthRasteriser rasteriser;
  for (const Mesh& mesh : {one, other}) {
    rasteriser.Render(mesh, Pose::Identity(), kCamera, kWhole);
    const int centre = 60 * 160 + 80;
    EXPECT_TRUE(rasteriser.Normal(mesh, centre).isApprox(Eigen::Vector3f(0, 0, -1)));
  }
}

TEST(DepthRasteriser, AnEmptyWindowGivesEmptyBuffers) {
  DepthRasteriser rasteriser;
  rasteriser.Render(OneTriangle({-1, -1, 1}, {1, -1, 1}, {0, 1, 1}), Pose::Identity(), kCamera,
                    PixelRect{});
  EXPECT_TRUE(rasteriser.depth().empty());
  EXPECT_TRUE(rasteriser.triangle().empty());
}

}  // namespace
}  // namespace secondlook::geometry
