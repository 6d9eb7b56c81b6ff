#include "lib/perception/recognition_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace secondlook::perception {
namespace {

/// How high the centre lies above the lowest point of the hull when `down_M` points down [m].
double CenterHeight(const RecognitionModel& model, const Eigen::Vector3d& down_M) {
  double lowest = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3f& v : model.hull) {
    lowest = std::max(lowest, down_M.dot(v.cast<double>()));
  }
  return lowest - down_M.dot(model.center_M);
}

/// A slender flat cone without its tip, of eight faces: where it rolls from one to the next, the
/// way down is along an edge.
geometry::Mesh Cone() {
  geometry::Mesh mesh = geometry::MakeCylinder(0.0325, 0.28, 8, {0.5F, 0.5F, 0.5F});
  for (Eigen::Vector3f& v : mesh.vertices) {
    if (v.z() > 0.0F) v.head<2>() *= 0.4F;
    v.x() *= 1.5F;
  }
  return mesh;
}

TEST(TrainModel, TakesForARestOnlyADirectionThatNoneNearbyIsLowerThan) {
  const RecognitionModel model = TrainModel({"cone", Cone(), 1});
  ASSERT_FALSE(model.resting_M.empty());
  for (const Eigen::Vector3d& down_M : model.resting_M) {
    const double height = CenterHeight(model, down_M);
    const Eigen::Vector3d side = down_M.unitOrthogonal();
    const Eigen::Vector3d other = down_M.cross(side);
    for (int k = 0; k < 360; ++k) {
      const double heading = k * std::numbers::pi / 180.0;
      const Eigen::Vector3d near_M =
          (down_M + 0.05 * (std::cos(heading) * side + std::sin(heading) * other)).normalized();
      EXPECT_GT(CenterHeight(model, near_M), height - 1e-4)
          << "down " << down_M.transpose() << ", heading " << k << " deg";
    }
  }
}

TEST(TrainModel, FindsTheRestsOfABoxOnItsThreeSides) {
  const RecognitionModel model =
      TrainModel({"box", geometry::MakeBox({0.1, 0.15, 0.22}, {0.5F, 0.5F, 0.5F}), 1});
  ASSERT_EQ(model.resting_M.size(), 3U);
  // The most stable first: on its largest side.
  EXPECT_GT(std::abs(model.resting_M[0].x()), 0.999);
  EXPECT_GT(std::abs(model.resting_M[1].y()), 0.999);
  EXPECT_GT(std::abs(model.resting_M[2].z()), 0.999);
}

}  // namespace
}  // namespace secondlook::perception
