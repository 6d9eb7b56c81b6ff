#include "lib/geometry/orient.h"

#include <utility>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::geometry {
namespace {

/// Of a closed mesh: positive when it is wound outward [m^3].
double Volume(const Mesh& mesh) {
  double volume = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    volume += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6.0;
  }
  return volume;
}

TEST(OrientOutward, LeavesAMeshThatIsRightAsItIs) {
  Mesh mesh = MakeSphere(0.1, 20, {0.5F, 0.5F, 0.5F});
  const double volume = Volume(mesh);
  EXPECT_EQ(OrientOutward(&mesh), 0);
  EXPECT_EQ(Volume(mesh), volume);
}

TEST(OrientOutward, TurnsOverAMeshThatIsInsideOut) {
  Mesh mesh = MakeCylinder(0.04, 0.1, 30, {0.5F, 0.5F, 0.5F});
  const double volume = Volume(mesh);
  for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(OrientOutward(&mesh), static_cast<int>(mesh.triangles.size()));
  EXPECT_NEAR(Volume(mesh), volume, 1e-9);
}

TEST(OrientOutward, TurnsOverTheTrianglesThatWindTheWrongWay) {
  Mesh mesh = MakeSphere(0.1, 20, {0.5F, 0.5F, 0.5F});
  const double volume = Volume(mesh);
  Rng rng(1);
  int turned = 0;
  for (Eigen::Vector3i& t : mesh.triangles) {
    if (rng.Uniform(0.0, 1.0) < 0.7) continue;
    std::swap(t[0], t[1]);
    ++turned;
  }
  EXPECT_EQ(OrientOutward(&mesh), turned);
  EXPECT_NEAR(Volume(mesh), volume, 1e-9);
}

TEST(OrientOutward, LeavesASheetAsItIs) {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_EQ(OrientOutward(&mesh), 0);
}

}  // namespace
}  // namespace secondlook::geometry
