#include "lib/geometry/thin_out.h"

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::geometry {
namespace {

/// How far the farthest vertex lies from a sphere of `radius` about the origin [m].
double FarthestFromSphere(const Mesh& mesh, double radius) {
  double farthest = 0.0;
  for (const Eigen::Vector3f& p : mesh.vertices) {
    farthest = std::max(farthest, std::abs(p.norm() - radius));
  }
  return farthest;
}

TEST(ThinOut, KeepsTheShapeToAFractionOfTheCell) {
  const Mesh fine = MakeSphere(0.1, 100, {0.2F, 0.4F, 0.6F});
  const Mesh coarse = ThinOut(fine, 0.01);
  EXPECT_LT(coarse.triangles.size(), fine.triangles.size() / 5);
  EXPECT_GT(coarse.triangles.size(), 500U);
  // Points in a cell of 10 mm lie at most 17 mm apart; the middle of an arc of that chord is
  // 17^2 / (8 * 100) = 0.4 mm below it.
  EXPECT_LT(FarthestFromSphere(coarse, 0.1), 4e-4);
  for (const Eigen::Vector3i& t : coarse.triangles) {
    EXPECT_TRUE(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    EXPECT_LT(t.maxCoeff(), static_cast<int>(coarse.vertices.size()));
  }
}

TEST(ThinOut, ColorsAreMeans) {
  Mesh mesh = MakeBox({0.1, 0.1, 0.1}, {1.0F, 1.0F, 1.0F});
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertex_colors.assign(mesh.vertices.size(), Eigen::Vector3f(1.0F, 0.0F, 0.0F));
  mesh.vertices.push_back(mesh.vertices[0] + Eigen::Vector3f(0.001F, 0.0F, 0.0F));
  mesh.vertex_colors.emplace_back(0.0F, 1.0F, 0.0F);
  mesh.triangles.emplace_back(0, first, 1);  // a sliver
  mesh.triangle_material.push_back(0);
  const Mesh thin = ThinOut(mesh, 0.02);
  EXPECT_EQ(thin.vertices.size(), 8U);
  EXPECT_EQ(thin.triangles.size(), 12U);
  EXPECT_TRUE(thin.vertex_colors[0].isApprox(Eigen::Vector3f(0.5F, 0.5F, 0.0F)));
}

TEST(ThinOut, NeedsACell) {
  EXPECT_THROWS(ThinOut(MakeSphere(0.1, 5, {1, 1, 1}), 0.0), InvalidArgument, "cells of 0 m");
}

}  // namespace
}  // namespace secondlook::geometry
