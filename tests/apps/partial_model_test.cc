#include "apps/partial_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "apps/experiments/free_camera.h"
#include "apps/experiments/pedestal.h"
#include "lib/geometry/mesh_border.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kRadius = 0.038;  ///< Of the soup can [m].
constexpr double kRim = 0.025;

/// The side of a cylinder about the z axis between two heights, seen over `arc` [rad].
world::PartialMesh Side(double radius, double low, double high, double arc) {
  constexpr int kAround = 90;
  constexpr int kUp = 60;
  world::PartialMesh side;
  for (int j = 0; j <= kUp; ++j) {
    for (int i = 0; i <= kAround; ++i) {
      const double a = arc * i / kAround;
      const Vector3d normal(std::cos(a), std::sin(a), 0.0);
      const Vector3d p = radius * normal + (low + (high - low) * j / kUp) * Vector3d::UnitZ();
      side.mesh.vertices.push_back(p.cast<float>());
      side.normals.push_back(normal.cast<float>());
      side.density.push_back(1.0F);
      if (i == kAround || j == kUp) continue;
      const int at = j * (kAround + 1) + i;
      side.mesh.triangles.emplace_back(at, at + 1, at + kAround + 2);
      side.mesh.triangles.emplace_back(at, at + kAround + 2, at + kAround + 1);
    }
  }
  return side;
}

double Area(const geometry::Mesh& mesh) {
  double area = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3f a = mesh.vertices[t[0]];
    area += 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
  }
  return area;
}

TEST(StandingMesh, OfACylinderGoesStraightDownToItsFoot) {
  const double arc = std::numbers::pi;
  const geometry::Mesh mesh = StandingMesh(Side(0.04, 0.01, 0.1, arc), {0.0, 0.0, 0.0}, kRim);
  for (const Vector3f& vertex : mesh.vertices) {
    EXPECT_NEAR(vertex.head<2>().norm(), 0.04, 1e-6);
  }
  EXPECT_EQ(geometry::Bounds(mesh).min().z(), 0.0);
  // Half a cylinder, from the table to its top, and no face beside what was seen of it.
  EXPECT_NEAR(Area(mesh), 0.04 * arc * 0.1, 1e-5);
}

TEST(StandingMesh, OfWhatTheScansLeanOutwardsAtItsFootIsNoWider) {
  world::PartialMesh side = Side(0.04, 0.01, 0.1, 6.0);
  for (Vector3f& normal : side.normals) normal = (normal + 0.8F * Vector3f::UnitZ()).normalized();
  for (const Vector3f& vertex : StandingMesh(side, {0.0, 0.0, 0.0}, kRim).vertices) {
    EXPECT_LE(vertex.head<2>().norm(), 0.04F + 1e-6F);
  }
}

TEST(StandingMesh, LeavesAHighBorderOpen) {
  const world::PartialMesh side = Side(0.04, 0.05, 0.1, 3.0);
  EXPECT_EQ(StandingMesh(side, {0.0, 0.0, 0.0}, kRim).triangles.size(), side.mesh.triangles.size());
}

TEST(StandingMesh, OfALowBandIsNotClosedFromItsUpperBorder) {
  const geometry::Mesh mesh = StandingMesh(Side(0.04, 0.01, 0.02, 3.0), {0.0, 0.0, 0.0}, kRim);
  EXPECT_NEAR(Area(mesh), 0.04 * 3.0 * 0.02, 1e-5);
}

/// A can on a pedestal, scanned from all around.
class ScannedCan : public ::testing::Test {
 protected:
  ScannedCan() : camera_(OnPedestal(TheCan()), 5) {
    plane_W_.offset = camera_.world().scene().table.height;
    const Vector3d middle_W(0.0, 0.0, plane_W_.offset + 0.055);
    const Vector3d around = Vector3d::Constant(0.12);
    model_.emplace(config_, Eigen::AlignedBox3d(middle_W - around, middle_W + around), plane_W_);
    for (int k = 0; k < 8; ++k) {
      const double azimuth = k * std::numbers::pi / 4.0;
      const Vector3d way_W(0.82 * std::cos(azimuth), 0.82 * std::sin(azimuth), 0.57);
      world::Observation view;
      view.X_WC = LookAt(middle_W + 1.1 * way_W, middle_W);
      view.frame = camera_.Take(view.X_WC).frame;
      view.camera = camera_.info().model;
      EXPECT_EQ(model_->Add(ScanOf(view, model_->box_W(), config_)), "");
    }
    const sim::PlacedObject& can = camera_.world().objects().at(0);
    for (const Vector3f& p_M : can.mesh.vertices) {
      points_W_.push_back(can.X_WM * p_M.cast<double>());
    }
  }

  static sim::SceneObject TheCan() {
    sim::SceneObject can;
    can.mesh = "sim/models/soup_can/mesh.obj";
    can.name = "can";
    return can;
  }

  FreeCamera camera_;
  ModellingConfig config_;
  world::SupportPlane plane_W_;
  std::optional<PartialModel> model_;
  std::vector<Vector3d> points_W_;
};

TEST_F(ScannedCan, IsNoWiderThanTheCanByMoreThanAVoxel) {
  model_->Separate(points_W_, {});
  EXPECT_GT(model_->coverage().Reachable(), 0.9);
  double widest = 0.0;
  for (const Vector3f& vertex :
       StandingMesh(model_->surface(), {0.0, 0.0, plane_W_.offset}, kRim).vertices) {
    widest = std::max(widest, static_cast<double>(vertex.head<2>().norm()));
  }
  EXPECT_LT(widest, kRadius + config_.surface.voxel_m);
}

TEST_F(ScannedCan, IsPartedFromWhatTouchesItByTheirPoints) {
  const auto beyond = std::partition(points_W_.begin(), points_W_.end(),
                                     [](const Vector3d& p_W) { return p_W.x() > 0.0; });
  const std::vector<Vector3d> others_W(beyond, points_W_.end());
  points_W_.erase(beyond, points_W_.end());
  model_->Separate(points_W_, others_W);
  // Half of the can is the thing's, the other half belongs to what touches it.
  const Eigen::AlignedBox3d box_W = geometry::Bounds(model_->surface().mesh);
  EXPECT_GT(box_W.min().x(), -2.0 * config_.surface.voxel_m);
  EXPECT_GT(box_W.max().x(), kRadius - config_.surface.voxel_m);
}

}  // namespace
}  // namespace secondlook::apps
