#include "lib/geometry/mesh_border.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace secondlook::geometry {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(BorderLoops, GoAroundASquareAsItsTrianglesDo) {
  Mesh square;
  square.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_THAT(BorderLoops(square), ElementsAre(ElementsAre(0, 1, 2, 3)));
}

TEST(BorderLoops, AreTwoOfATubeAndNoneOfABall) {
  Mesh can = MakeSphere(1.0, 20, Eigen::Vector3f::Zero());
  EXPECT_THAT(BorderLoops(can), IsEmpty());
  std::erase_if(can.triangles, [&](const Eigen::Vector3i& t) {
    for (int k = 0; k < 3; ++k) {
      if (std::abs(can.vertices[t[k]].z()) > 0.7F) return true;
    }
    return false;
  });
  EXPECT_EQ(BorderLoops(can).size(), 2U);
  EXPECT_THAT(BorderLoops(Mesh{}), IsEmpty());
}

}  // namespace
}  // namespace secondlook::geometry
