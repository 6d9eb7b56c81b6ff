#include "sim/fixtures.h"

#include <algorithm>
#include <limits>
#include <numbers>

namespace secondlook::sim {
namespace {

using Eigen::Vector3d;

constexpr double kSlab = 0.05;      // [m] thickness of the floor and of the walls
constexpr double kLeg = 0.05;       // [m] side of a table leg
constexpr double kLegInset = 0.04;  // [m] from the edge of the top to the leg
constexpr double kRadians = std::numbers::pi / 180.0;

/// A box whose bottom face is centred at `bottom` [m] and turned by `yaw` [rad].
Fixture MakeStandingBox(const std::string& name, int id, const Vector3d& size,
                        const Vector3d& bottom, double yaw, const Vector3d& color) {
  Fixture fixture;
  fixture.name = name;
  fixture.id = id;
  fixture.mesh = geometry::MakeBox(size, color.cast<float>());
  fixture.X_WM.linear() = RotationFromRollPitchYaw(0.0, 0.0, yaw);
  fixture.X_WM.translation() = bottom + Vector3d(0.0, 0.0, size.z() / 2);
  return fixture;
}

void AddWalls(const Scene& scene, std::vector<Fixture>* fixtures) {
  if (!scene.walls) return;
  const Walls& walls = *scene.walls;
  const Eigen::Vector2d half = scene.floor.size / 2;
  for (const double side : {-1.0, 1.0}) {
    fixtures->push_back(
        MakeStandingBox("wall", kWallId, {kSlab, scene.floor.size.y() + 2 * kSlab, walls.height},
                        {side * (half.x() + kSlab / 2), 0.0, 0.0}, 0.0, walls.color));
    fixtures->push_back(
        MakeStandingBox("wall", kWallId, {scene.floor.size.x(), kSlab, walls.height},
                        {0.0, side * (half.y() + kSlab / 2), 0.0}, 0.0, walls.color));
  }
}

void AddTable(const Table& table, std::vector<Fixture>* fixtures) {
  const double yaw = table.yaw_deg * kRadians;
  const auto add = [&](const Vector3d& size, const Vector3d& bottom_T) {
    const Eigen::Vector2d offset = Eigen::Rotation2Dd(yaw) * bottom_T.head<2>();
    fixtures->push_back(MakeStandingBox(
        "table", kTableId, size,
        {table.position.x() + offset.x(), table.position.y() + offset.y(), bottom_T.z()}, yaw,
        table.color));
  };
  const double top = table.solid ? table.height : table.thickness;
  add({table.size.x(), table.size.y(), top}, {0.0, 0.0, table.height - top});
  if (table.solid) return;
  const Eigen::Vector2d leg = table.size / 2 - Eigen::Vector2d::Constant(kLegInset + kLeg / 2);
  for (const double x : {-leg.x(), leg.x()}) {
    for (const double y : {-leg.y(), leg.y()}) {
      add({kLeg, kLeg, table.height - top}, {x, y, 0.0});
    }
  }
}

double LowestPoint(const Fixture& fixture) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3f& p_MV : fixture.mesh.vertices) {
    lowest = std::min(lowest, (fixture.X_WM * p_MV.cast<double>()).z());
  }
  return lowest;
}

}  // namespace

std::vector<Fixture> MakeFixtures(const Scene& scene, const std::vector<PlacedObject>& objects,
                                  double robot_height) {
  std::vector<Fixture> fixtures;
  fixtures.push_back(MakeStandingBox("floor", kFloorId,
                                     {scene.floor.size.x(), scene.floor.size.y(), kSlab},
                                     {0.0, 0.0, -kSlab}, 0.0, scene.floor.color));
  AddWalls(scene, &fixtures);
  AddTable(scene.table, &fixtures);
  for (const SceneBox& box : scene.boxes) {
    fixtures.push_back(MakeStandingBox(box.name, kBoxId, box.size, box.position,
                                       box.yaw_deg * kRadians, box.color));
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const int id = kFirstObjectId + static_cast<int>(i);
    fixtures.push_back({objects[i].name, objects[i].X_WM, objects[i].mesh, id, false});
  }
  for (Fixture& fixture : fixtures) {
    fixture.in_the_way = fixture.id != kFloorId && LowestPoint(fixture) < robot_height;
  }
  return fixtures;
}

std::vector<Footprint> MakeFootprints(const std::vector<Fixture>& fixtures) {
  std::vector<Footprint> footprints;
  for (const Fixture& fixture : fixtures) {
    if (!fixture.in_the_way) continue;
    footprints.push_back(MakeFootprint(fixture.name, fixture.mesh, fixture.X_WM));
  }
  return footprints;
}

}  // namespace secondlook::sim
