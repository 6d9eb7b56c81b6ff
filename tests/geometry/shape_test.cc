#include "lib/geometry/shape.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::geometry {
namespace {

const Shape kShapes[] = {Box{{0.2, 0.4, 0.6}}, Cylinder{0.3, 0.8}, Sphere{0.5}};

TEST(Shape, IsAsFarAsItsNearestPoint) {
  EXPECT_NEAR(Distance(kShapes[0], {0.1 + 0.3, 0.2 + 0.4, 0.1}), 0.5, 1e-12);
  EXPECT_NEAR(Distance(kShapes[1], {0.0, 0.3 + 0.3, -0.4 - 0.4}), 0.5, 1e-12);
  EXPECT_NEAR(Distance(kShapes[2], {0.0, 0.0, -0.7}), 0.2, 1e-12);
  for (const Shape& shape : kShapes) EXPECT_EQ(Distance(shape, {0.05, 0.1, -0.2}), 0.0);
}

TEST(Shape, HasItsMeshOnItsSurfaceAndInItsBoundingBall) {
  for (const Shape& shape : kShapes) {
    const Mesh mesh = MakeMesh(shape, 24, {1, 0, 0});
    double farthest = 0.0;
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
      const Eigen::Vector3d p_SV = vertex.cast<double>();
      EXPECT_LT(Distance(shape, p_SV), 1e-6);
      EXPECT_GT(Distance(shape, 1.01 * p_SV), 1e-4);
      farthest = std::max(farthest, p_SV.norm());
    }
    EXPECT_NEAR(farthest, BoundingRadius(shape), 1e-3);
  }
}

TEST(Shape, DistanceGrowsNoFasterThanTheWay) {
  Rng rng(3);
  const auto draw = [&] {
    return Eigen::Vector3d(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1));
  };
  for (const Shape& shape : kShapes) {
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d a = draw();
      const Eigen::Vector3d b = draw();
      EXPECT_LE(std::abs(Distance(shape, a) - Distance(shape, b)), (a - b).norm() + 1e-12);
    }
  }
}

}  // namespace
}  // namespace secondlook::geometry
