#include "apps/partial_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "lib/geometry/kd_tree.h"
#include "lib/geometry/mesh_border.h"
#include "lib/geometry/point_image.h"
#include "lib/perception/register_scan.h"
#include "lib/world/scan_patches.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

/// Farther from all that is seen of a thing, a surface is not the thing's [m].
constexpr double kOwn_m = 0.02;
/// The direction of a jagged border is that between so many vertices before and behind.
constexpr int kStretch = 3;
/// A surface ends downwards where it goes on so steeply beyond its border: z of the unit direction.
constexpr float kDownwards = -0.3F;
/// What faces up so much is a top, whose sides nobody has seen: z of the unit normal.
constexpr float kTop = 0.7F;
/// What faces up or down more than this has no side that it could lean to: sine of the slope.
constexpr float kLevel = 0.2F;

/// Where the surface beside a border `height` above the support meets it, from right below: what
/// turns inwards goes on to do so, but not flatter than 45 degrees. What leans outwards, as a thing
/// blurred with its support does, goes straight down.
Eigen::Vector2f InwardToFoot(const Eigen::Vector3f& normal, float height) {
  const float level = normal.head<2>().norm();
  if (normal.z() >= 0.0F || level < kLevel) return Eigen::Vector2f::Zero();
  const float slope = std::min(-normal.z() / level, 1.0F);
  return -slope * std::max(height, 0.0F) * normal.head<2>() / level;
}

}  // namespace

world::RangeScan ScanOf(const world::Observation& view, const Eigen::AlignedBox3d& box_W,
                        const ModellingConfig& config) {
  world::RangeScan scan;
  const geometry::PointImage cloud = geometry::Deproject(view.frame.depth, view.camera);
  for (int i = 0; i < static_cast<int>(cloud.points_C.size()); ++i) {
    const Eigen::Vector3f& p_CP = cloud.points_C[i];
    if (!geometry::IsMeasured(p_CP)) continue;
    const Vector3d p_WP = view.X_WC * p_CP.cast<double>();
    if (!box_W.contains(p_WP)) continue;
    scan.points_W.push_back(p_WP);
    scan.sigmas.push_back(static_cast<float>(geometry::DepthSigma(p_CP.z())));
    if (view.frame.color.empty()) continue;
    const auto& rgb = view.frame.color.at<cv::Vec3b>(i / cloud.width, i % cloud.width);
    scan.colors.emplace_back(Eigen::Vector3f(rgb[0], rgb[1], rgb[2]) / 255.0F);
  }
  scan.lines = {{view.X_WC.translation(), static_cast<int>(scan.points_W.size())}};
  scan.position_sigma = config.view_m;
  scan.rotation_sigma = config.view_rad;
  return scan;
}

PartialModel::PartialModel(const ModellingConfig& config, const Eigen::AlignedBox3d& box_W,
                           const world::SupportPlane& plane_W)
    : config_(config), plane_W_(plane_W), volume_(config.surface, box_W) {}

std::string PartialModel::Add(world::RangeScan scan) {
  if (scan.empty()) return "it measured nothing there";
  world::ScanPatches patches = world::CutIntoPatches(scan, volume_.patch());
  if (!all_.mesh.empty()) {
    const double voxel = config_.surface.voxel_m;
    perception::RegisteredScan placed = perception::RegisterScan(
        std::move(scan), std::move(patches), all_, voxel, perception::ScanRegisterConfig(voxel));
    if (!placed.registration.accepted) return placed.registration.reason;
    scan = std::move(placed.scan);
    patches = std::move(placed.patches);
  }
  volume_.Integrate(scan, patches);
  all_ = volume_.Extract();
  ++scans_;
  return "";
}

void PartialModel::Separate(const std::vector<Vector3d>& own_W,
                            const std::vector<Vector3d>& others_W) {
  std::vector<char> own(all_.mesh.vertices.size(), 0);
  if (!own_W.empty()) {
    const geometry::KdTree thing(own_W);
    std::optional<geometry::KdTree> others;
    if (!others_W.empty()) others.emplace(others_W);
    for (std::size_t i = 0; i < own.size(); ++i) {
      const Vector3d p_W = all_.mesh.vertices[i].cast<double>();
      if (plane_W_.HeightOf(p_W) <= config_.stands_m) continue;
      const auto nearest = thing.Nearest(p_W, kOwn_m);
      if (!nearest) continue;
      const bool nearer_to_another =
          others && others->Nearest(p_W, std::sqrt(nearest->squared_distance)).has_value();
      own[i] = nearer_to_another ? 0 : 1;
    }
  }
  surface_ = perception::Part(all_, own);
  coverage_ = perception::EstimateCoverage(surface_, plane_W_, config_.borders.footing_m);
}

geometry::Mesh StandingMesh(const world::PartialMesh& surface, const Vector3d& p_WM, double rim) {
  geometry::Mesh mesh = surface.mesh;
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex -= p_WM.cast<float>();
  std::map<int, int> feet;
  const auto foot_of = [&](int i) {
    const auto [foot, is_new] = feet.try_emplace(i, static_cast<int>(mesh.vertices.size()));
    if (!is_new) return foot->second;
    const Eigen::Vector3f vertex = mesh.vertices[i];
    const Eigen::Vector2f down = vertex.head<2>() + InwardToFoot(surface.normals[i], vertex.z());
    mesh.vertices.emplace_back(down.x(), down.y(), 0.0F);
    if (!mesh.vertex_colors.empty()) {
      const Eigen::Vector3f color = mesh.vertex_colors[i];
      mesh.vertex_colors.push_back(color);
    }
    return foot->second;
  };
  for (const std::vector<int>& loop : geometry::BorderLoops(surface.mesh)) {
    const int count = static_cast<int>(loop.size());
    const auto at = [&](int i) { return loop[(i % count + count) % count]; };
    const auto ends_downwards = [&](int i) {
      const Eigen::Vector3f along =
          mesh.vertices[at(i + 1 + kStretch)] - mesh.vertices[at(i - kStretch)];
      const Eigen::Vector3f& normal = surface.normals[at(i)];
      return normal.z() > kTop || along.cross(normal).normalized().z() < kDownwards;
    };
    const auto low = [&](int i) { return mesh.vertices[i].z() < static_cast<float>(rim); };
    for (int i = 0; i < count; ++i) {
      const int a = at(i);
      const int b = at(i + 1);
      if (!low(a) || !low(b) || !ends_downwards(i)) continue;
      mesh.triangles.emplace_back(b, a, foot_of(a));
      mesh.triangles.emplace_back(b, foot_of(a), foot_of(b));
    }
  }
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  return mesh;
}

}  // namespace secondlook::apps
