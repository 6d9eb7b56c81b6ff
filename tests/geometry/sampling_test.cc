#include "lib/geometry/sampling.h"

#include <set>
#include <tuple>

#include <gtest/gtest.h>

namespace secondlook::geometry {
namespace {

const Eigen::Vector3f kGrey(0.5F, 0.5F, 0.5F);

TEST(SampleSurface, SpreadsPointsByAreaOnTheSurface) {
  const Mesh box = MakeBox({0.1, 0.2, 0.4}, kGrey);
  Rng rng(1);
  int on_large_face = 0;
  const auto samples = SampleSurface(box, 2800, &rng);
  ASSERT_EQ(samples.size(), 2800U);
  for (const MeshSample& sample : samples) {
    const Eigen::Vector3f& p = sample.surface.point;
    const Eigen::Vector3f to_side = (Eigen::Vector3f(0.05F, 0.1F, 0.2F) - p.cwiseAbs()).cwiseAbs();
    EXPECT_LT(to_side.minCoeff(), 1e-6F);
    // Outward: the normal points away from the centre.
    EXPECT_GT(sample.surface.normal.dot(p), 0.0F);
    EXPECT_NEAR(sample.weights.sum(), 1.0F, 1e-5F);
    on_large_face += std::abs(p.x()) > 0.05F - 1e-6F ? 1 : 0;
  }
  // The two sides of 0.2 x 0.4 are 0.16 of 0.28 square metres: 1600 of the 2800 points.
  EXPECT_NEAR(on_large_face, 1600, 4);
}

TEST(SampleSurface, DependsOnTheSeedAlone) {
  const Mesh box = MakeBox({0.1, 0.2, 0.4}, kGrey);
  Rng one(7);
  Rng two(7);
  const auto a = SampleSurface(box, 50, &one);
  const auto b = SampleSurface(box, 50, &two);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].surface.point, b[i].surface.point);
}

TEST(SubsampleByNormals, KeepsOnePointOfACellForEachDirection) {
  const Eigen::Vector3f up(0, 0, 1);
  const Eigen::Vector3f side(1, 0, 0);
  const std::vector<OrientedPoint> points{
      {{0.001F, 0, 0}, up},   {{0.002F, 0, 0}, up},  {{0.003F, 0, 0}, side},
      {{0.004F, 0, 0}, side}, {{0.0101F, 0, 0}, up}, {{-0.001F, 0, 0}, up},
  };
  EXPECT_EQ(SubsampleByNormals(points, 0.01, 0.5), (std::vector<int>{0, 2, 4, 5}));
  EXPECT_EQ(SubsampleByNormals(points, 0.01, 3.2), (std::vector<int>{0, 4, 5}));
  EXPECT_TRUE(SubsampleByNormals({}, 0.01, 0.5).empty());
}

TEST(SubsampleByNormals, LeavesNoTwoPointsOfOneCellAndDirection) {
  Rng rng(2);
  std::vector<OrientedPoint> points;
  for (int i = 0; i < 3000; ++i) {
    points.push_back({{static_cast<float>(rng.Uniform(-0.1, 0.1)),
                       static_cast<float>(rng.Uniform(-0.1, 0.1)), 0.005F},
                      {0, 0, 1}});
  }
  std::set<std::tuple<int, int>> cells;
  const std::vector<int> kept = SubsampleByNormals(points, 0.02, 0.5);
  for (const int i : kept) {
    const Eigen::Vector3f& p = points[static_cast<std::size_t>(i)].point;
    EXPECT_TRUE(cells
                    .insert({static_cast<int>(std::floor(p.x() / 0.02)),
                             static_cast<int>(std::floor(p.y() / 0.02))})
                    .second);
  }
  EXPECT_EQ(kept.size(), 100U);
}

}  // namespace
}  // namespace secondlook::geometry
