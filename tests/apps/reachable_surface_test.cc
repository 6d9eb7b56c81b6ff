#include "apps/experiments/reachable_surface.h"

#include <gtest/gtest.h>

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

/// A cube of 10 cm on a table of 0.75 m: of its six faces one is hidden.
std::vector<SurfacePoint> Cube() {
  const geometry::Mesh mesh = geometry::MakeBox({0.1, 0.1, 0.1}, {1.0F, 1.0F, 1.0F});
  return ReachableSurface(mesh, Pose(Eigen::Translation3d(0.2, -0.1, 0.8)), 0.75, 1200, 1);
}

std::vector<Vector3d> Moved(const std::vector<SurfacePoint>& points, const Vector3d& shift,
                            double highest) {
  std::vector<Vector3d> moved;
  for (const SurfacePoint& point : points) {
    if (point.p_W.z() <= highest) moved.push_back(point.p_W + shift);
  }
  return moved;
}

TEST(ReachableSurface, IsAllButWhatTheObjectStandsOn) {
  for (const SurfacePoint& point : Cube()) {
    EXPECT_EQ(point.reachable, point.normal_W.z() > -0.5) << point.p_W.transpose();
  }
}

TEST(CompareSurface, IsAfterARigidAlignment) {
  const std::vector<SurfacePoint> cube = Cube();
  const SurfaceFigures figures = CompareSurface(Moved(cube, {0.003, -0.002, 0.004}, 1.0), cube);
  EXPECT_NEAR(figures.rms, 0.0, 2e-4);
  EXPECT_GT(figures.all_within_1mm, 0.99);
  EXPECT_GT(figures.reachable_within_1mm, 0.99);
}

TEST(CompareSurface, CountsWhatIsMissing) {
  const std::vector<SurfacePoint> cube = Cube();
  // Without the upper half of the sides and the top, three sixths of what there is are left, and
  // of the five that can be seen two.
  const SurfaceFigures figures = CompareSurface(Moved(cube, {0.0, 0.0, 0.0}, 0.8), cube);
  EXPECT_NEAR(figures.all_within_1mm, 3.0 / 6.0, 0.02);
  EXPECT_NEAR(figures.reachable_within_1mm, 2.0 / 5.0, 0.02);
  EXPECT_EQ(CompareSurface({}, cube).all_within_1mm, 0.0);
}

TEST(SpreadOver, HasAPointForEachSquare) {
  const geometry::Mesh mesh = geometry::MakeBox({0.1, 0.1, 0.1}, {1.0F, 1.0F, 1.0F});
  EXPECT_NEAR(static_cast<double>(SpreadOver(mesh, 0.01, 1).size()), 600.0, 1.0);
  EXPECT_TRUE(SpreadOver({}, 0.01, 1).empty());
}

}  // namespace
}  // namespace secondlook::apps
