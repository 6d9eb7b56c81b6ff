#include "lib/perception/recognition_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

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

TEST(TrainModel, RefusesAMeshFromWhichNothingCanBeLearned) {
  geometry::Mesh mesh = geometry::MakeBox({0.1, 0.1, 0.1}, {0.5F, 0.5F, 0.5F});
  geometry::Mesh empty = mesh;
  empty.triangles.clear();
  EXPECT_THROWS(TrainModel({"box", empty, 1}), InvalidArgument,
                "model 'box': its mesh has no triangle");
  geometry::Mesh flat = mesh;
  for (Eigen::Vector3f& v : flat.vertices) v = Eigen::Vector3f(v.x(), 0.0F, 0.0F);
  EXPECT_THROWS(TrainModel({"box", flat, 1}), InvalidArgument,
                "model 'box': its surface has no area");
  mesh.vertices[3].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROWS(TrainModel({"box", mesh, 1}), InvalidArgument,
                "model 'box': vertex 3 of 8 is not finite");
}

TEST(TrainModel, MakesTheSameOfAMeshThatIsInsideOut) {
  const geometry::Mesh mesh = geometry::MakeCylinder(0.04, 0.1, 24, {0.5F, 0.5F, 0.5F});
  geometry::Mesh inside_out = mesh;
  for (Eigen::Vector3i& t : inside_out.triangles) std::swap(t[1], t[2]);
  const RecognitionModel one = TrainModel({"can", mesh, 1});
  const RecognitionModel other = TrainModel({"can", inside_out, 1});
  for (std::size_t i = 0; i < one.points.size(); ++i) {
    ASSERT_EQ(one.points[i].normal, other.points[i].normal);
    ASSERT_GT(one.points[i].normal.dot(one.points[i].point - Eigen::Vector3f(0, 0, 0.05F)), 0.0F);
  }
}

TEST(TrainModel, TakesASingleTriangle) {
  geometry::Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.triangle_material = {0};
  mesh.materials.resize(1);
  const RecognitionModel model = TrainModel({"sheet", mesh, 1});
  EXPECT_NEAR(model.area, 0.005, 1e-9);
  EXPECT_EQ(model.hull.size(), 3U);
  EXPECT_TRUE(model.ppf.entries.empty());  // all its point pairs lie in one plane
}

}  // namespace
}  // namespace secondlook::perception
