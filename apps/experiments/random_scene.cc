#include "apps/experiments/random_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "lib/common/pose.h"
#include "lib/geometry/mesh.h"
#include "lib/world/object_database.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector2d;

constexpr double kPi = std::numbers::pi;
constexpr double kGap = 0.03;          // [m] between things
constexpr double kEdge = 0.02;         // [m] from things to the table's edge
constexpr double kRobotRadius = 0.28;  // [m]

/// The outline of a thing on the table: a rectangle.
struct Outline {
  Vector2d center;
  Vector2d half;
  double yaw{};

  std::vector<Vector2d> Corners() const {
    const Eigen::Rotation2Dd turn(yaw);
    return {center + turn * Vector2d(half.x(), half.y()),
            center + turn * Vector2d(-half.x(), half.y()),
            center + turn * Vector2d(-half.x(), -half.y()),
            center + turn * Vector2d(half.x(), -half.y())};
  }
};

/// The widest gap between two outlines along any of their edges' normals: less than 0 when they
/// overlap (separating axes).
double GapBetween(const Outline& a, const Outline& b) {
  double widest = -1e9;
  for (const double yaw : {a.yaw, a.yaw + kPi / 2.0, b.yaw, b.yaw + kPi / 2.0}) {
    const Vector2d axis(std::cos(yaw), std::sin(yaw));
    const auto range = [&](const Outline& o) {
      double low = 1e9;
      double high = -1e9;
      for (const Vector2d& corner : o.Corners()) {
        low = std::min(low, axis.dot(corner));
        high = std::max(high, axis.dot(corner));
      }
      return std::pair(low, high);
    };
    const auto [a_low, a_high] = range(a);
    const auto [b_low, b_high] = range(b);
    widest = std::max({widest, b_low - a_high, a_low - b_high});
  }
  return widest;
}

std::vector<sim::SceneObject> ObjectsOf(const std::string& folder, const std::string& role) {
  std::vector<sim::SceneObject> objects;
  const auto database = world::ObjectDatabase::Load(folder);
  for (const world::ObjectModel& model : database.models()) {
    sim::SceneObject object;
    object.mesh = (std::filesystem::path(folder) / model.name / "mesh.obj").string();
    object.name = model.name;
    object.role = role;
    objects.push_back(std::move(object));
  }
  return objects;
}

/// Takes a random object out of `pool`.
sim::SceneObject Draw(std::vector<sim::SceneObject>* pool, Rng* rng) {
  const int index = rng->Index(static_cast<int>(pool->size()));
  sim::SceneObject object = (*pool)[index];
  pool->erase(pool->begin() + index);
  return object;
}

/// Puts the object where it has room; false when none was found.
bool Place(const sim::Table& table, std::vector<Outline>* taken, sim::SceneObject* object,
           Rng* rng) {
  const Eigen::AlignedBox3d box =
      geometry::Bounds(geometry::LoadMesh(object->mesh, geometry::ParseLengthUnit(object->unit)));
  for (int attempt = 0; attempt < 200; ++attempt) {
    Outline outline;
    outline.yaw = rng->Uniform(-kPi, kPi);
    outline.half = box.sizes().head<2>() / 2.0;
    const Vector2d reach = table.size / 2.0 - Vector2d::Constant(kEdge);
    const Vector2d origin(rng->Uniform(-reach.x(), reach.x()), rng->Uniform(-reach.y(), reach.y()));
    outline.center = origin + Eigen::Rotation2Dd(outline.yaw) * box.center().head<2>();
    const std::vector<Vector2d> corners = outline.Corners();
    const bool on_table = std::all_of(corners.begin(), corners.end(), [&](const Vector2d& c) {
      return std::abs(c.x()) < reach.x() && std::abs(c.y()) < reach.y();
    });
    const bool free = std::all_of(taken->begin(), taken->end(), [&](const Outline& other) {
      return GapBetween(outline, other) >= kGap;
    });
    if (!on_table || !free) continue;
    taken->push_back(outline);
    object->position = {origin.x(), origin.y()};
    object->yaw_deg = outline.yaw * 180.0 / kPi;
    return true;
  }
  return false;
}

}  // namespace

Repertoire LoadRepertoire(const std::string& models, const std::string& unfamiliar) {
  Repertoire repertoire;
  repertoire.known = ObjectsOf(models, "known");
  if (!unfamiliar.empty()) repertoire.unknown = ObjectsOf(unfamiliar, "unknown");
  return repertoire;
}

sim::Scene DrawScene(const Repertoire& repertoire, Rng* rng) {
  sim::Scene scene;
  scene.name = "random";
  scene.walls.emplace();
  std::vector<sim::SceneObject> known = repertoire.known;
  std::vector<sim::SceneObject> unknown = repertoire.unknown;
  const int things = 5 + rng->Index(4);
  const int unfamiliar = std::min(std::max(0, rng->Index(4) - 1), static_cast<int>(unknown.size()));
  std::vector<Outline> taken;
  for (int i = 0; i < things; ++i) {
    auto& pool = i < unfamiliar ? unknown : known;
    if (pool.empty()) break;
    sim::SceneObject object = Draw(&pool, rng);
    if (Place(scene.table, &taken, &object, rng)) scene.objects.push_back(std::move(object));
  }

  PlaceRobot(&scene, rng);
  const int crates = rng->Index(3);
  for (int i = 0; i < crates; ++i) AddCrate(fmt::format("crate {}", i + 1), &scene, rng);
  return scene;
}

void PlaceRobot(sim::Scene* scene, Rng* rng) {
  const double side = rng->Uniform(-kPi, kPi);
  const double distance = rng->Uniform(1.5, 2.2);
  scene->robot.position = {distance * std::cos(side), distance * std::sin(side)};
  scene->robot.yaw_deg =
      (WrapAngle(side + kPi) + rng->Uniform(-15.0, 15.0) * kPi / 180.0) * 180.0 / kPi;
}

void AddCrate(const std::string& name, sim::Scene* scene, Rng* rng) {
  sim::SceneBox crate;
  crate.name = name;
  crate.size = {rng->Uniform(0.25, 0.5), rng->Uniform(0.25, 0.5), rng->Uniform(0.25, 0.9)};
  const double angle = rng->Uniform(-kPi, kPi);
  const double away = rng->Uniform(1.1, 2.2);
  crate.position = {away * std::cos(angle), away * std::sin(angle), 0.0};
  crate.yaw_deg = rng->Uniform(0.0, 90.0);
  const double room = crate.size.head<2>().norm() / 2.0 + kRobotRadius + 0.15;
  if ((crate.position.head<2>() - scene->robot.position).norm() > room) {
    scene->boxes.push_back(crate);
  }
}

sim::Scene DrawCrowdedTable(const std::vector<sim::SceneObject>& things, Rng* rng) {
  sim::Scene scene;
  scene.name = "crowded table";
  scene.table.size = {0.8, 0.6};
  scene.walls.emplace();
  for (int attempt = 0; attempt < 20 && scene.objects.size() < things.size(); ++attempt) {
    scene.objects.clear();
    std::vector<Outline> taken;
    for (sim::SceneObject object : things) {
      if (Place(scene.table, &taken, &object, rng)) scene.objects.push_back(std::move(object));
    }
  }
  return scene;
}

Pose DrawViewOf(const Eigen::Vector3d& target_W, Rng* rng) {
  const double azimuth = rng->Uniform(-std::numbers::pi, std::numbers::pi);
  const double elevation = rng->Uniform(20.0, 70.0) * std::numbers::pi / 180.0;
  const double distance = rng->Uniform(0.6, 1.2);
  const Eigen::Vector3d towards(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  return LookAt(target_W + distance * towards, target_W);
}

Pose DrawView(const sim::Table& table, Rng* rng) {
  const double x = table.position.x() + rng->Uniform(-0.1, 0.1);
  const double y = table.position.y() + rng->Uniform(-0.1, 0.1);
  return DrawViewOf({x, y, table.height + 0.05}, rng);
}

std::vector<sim::SceneObject> DrawObjects(std::vector<sim::SceneObject> pool, int count, Rng* rng) {
  std::vector<sim::SceneObject> drawn;
  while (!pool.empty() && static_cast<int>(drawn.size()) < count) {
    drawn.push_back(Draw(&pool, rng));
  }
  return drawn;
}

}  // namespace secondlook::apps
