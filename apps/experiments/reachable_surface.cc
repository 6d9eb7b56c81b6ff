#include "apps/experiments/reachable_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lib/geometry/kd_tree.h"
#include "lib/geometry/point_to_plane.h"
#include "lib/geometry/ray_caster.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

constexpr int kPlaces = 2000;
constexpr double kShells[] = {0.35, 0.45, 0.55};  // [m]
constexpr double kAboveTable = 0.05;              // [m]
constexpr double kMinCosine = 0.2588;             // of 75 degrees
constexpr double kOff = 1e-4;                     // [m] a ray starts above its surface
constexpr double kGate = 0.01;                    // [m] farther is no pair
constexpr int kIterations = 20;
constexpr std::size_t kAligned = 5000;  // points that the rigid motion is estimated from
constexpr std::size_t kBatch = 64;      // places tried together; most points are seen by the first

/// Evenly on a sphere (the golden angle), those above the table, shell after shell.
std::vector<Vector3d> Places(const Vector3d& middle_W, double table) {
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  std::vector<Vector3d> places;
  const int count = 2 * kPlaces;  // about half of them lie above the table
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / count;
    const double r = std::sqrt(1.0 - z * z);
    const Vector3d p_W =
        middle_W + kShells[i % 3] * Vector3d(r * std::cos(golden * i), r * std::sin(golden * i), z);
    if (p_W.z() >= table + kAboveTable) places.push_back(p_W);
  }
  // In another order, so that those tried first lie on all sides.
  std::vector<Vector3d> spread;
  for (std::size_t i = 0; i < kBatch; ++i) {
    for (std::size_t k = i; k < places.size(); k += kBatch) spread.push_back(places[k]);
  }
  return spread;
}

double RmsOf(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return values.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(values.size()));
}

}  // namespace

std::vector<SurfacePoint> ReachableSurface(const geometry::Mesh& mesh, const Pose& X_WM,
                                           double table, int count, std::uint64_t seed) {
  geometry::Mesh mesh_W = mesh;
  Eigen::AlignedBox3d box_W;
  for (Eigen::Vector3f& vertex : mesh_W.vertices) {
    const Vector3d p_W = X_WM * vertex.cast<double>();
    box_W.extend(p_W);
    vertex = p_W.cast<float>();
  }
  const geometry::RayCaster caster(mesh_W);
  Rng rng(seed);
  std::vector<SurfacePoint> points;
  const std::vector<Vector3d> places = Places(box_W.center(), table);
  for (const geometry::MeshSample& sample : geometry::SampleSurface(mesh_W, count, &rng)) {
    SurfacePoint point{sample.surface.point.cast<double>(),
                       sample.surface.normal.cast<double>().normalized(), false};
    for (std::size_t first = 0; first < places.size() && !point.reachable; first += kBatch) {
      std::vector<geometry::Ray> rays_W;
      for (std::size_t k = first; k < std::min(first + kBatch, places.size()); ++k) {
        const Vector3d way = places[k] - point.p_W;
        const double cosine = point.normal_W.dot(way.normalized());
        // Meshes may be open, and are then seen from both sides.
        if (std::abs(cosine) < kMinCosine) continue;
        const Vector3d start = point.p_W + std::copysign(kOff, cosine) * point.normal_W;
        rays_W.push_back({start.cast<float>(), way.normalized().cast<float>()});
      }
      for (const geometry::RayHit& hit : caster.Cast(rays_W)) {
        point.reachable = point.reachable || hit.triangle < 0;
      }
    }
    points.push_back(point);
  }
  return points;
}

SurfaceFigures CompareSurface(const std::vector<Vector3d>& measured_W,
                              const std::vector<SurfacePoint>& truth) {
  if (measured_W.empty() || truth.empty()) return {};
  std::vector<Vector3d> true_points;
  for (const SurfacePoint& point : truth) true_points.push_back(point.p_W);
  const geometry::KdTree tree(true_points);
  std::vector<Vector3d> moved = measured_W;
  const std::size_t every = 1 + moved.size() / kAligned;
  for (int i = 0; i < kIterations; ++i) {
    std::vector<geometry::PointPlanePair> pairs;
    for (std::size_t k = 0; k < moved.size(); k += every) {
      const Vector3d& p = moved[k];
      const auto nearest = tree.Nearest(p, kGate);
      if (nearest) {
        pairs.push_back({p, truth[nearest->index].p_W, truth[nearest->index].normal_W, 1.0});
      }
    }
    const geometry::PointPlaneStep step = geometry::SolvePointToPlane(pairs);
    for (Vector3d& p : moved) p = step.X * p;
  }
  SurfaceFigures figures;
  std::vector<double> distances;
  for (const Vector3d& p : moved) {
    const geometry::Neighbour nearest = tree.Nearest(p, 1).front();
    const SurfacePoint& point = truth[nearest.index];
    // Beside the plane of a sample its neighbours are nearer; beyond an edge nothing is.
    const double along = std::abs(point.normal_W.dot(p - point.p_W));
    const double apart = std::sqrt(nearest.squared_distance);
    distances.push_back(apart < 0.003 ? along : apart);
  }
  figures.rms = RmsOf(distances);
  const geometry::KdTree seen(std::move(moved));
  int reachable = 0;
  int all = 0;
  int within_3mm = 0;
  int all_reachable = 0;
  for (const SurfacePoint& point : truth) {
    const double apart = std::sqrt(seen.Nearest(point.p_W, 1).front().squared_distance);
    all += apart <= 0.001;
    if (!point.reachable) continue;
    ++all_reachable;
    reachable += apart <= 0.001;
    within_3mm += apart <= 0.003;
  }
  figures.all_within_1mm = all / static_cast<double>(truth.size());
  if (all_reachable == 0) return figures;
  figures.reachable_within_1mm = reachable / static_cast<double>(all_reachable);
  figures.reachable_within_3mm = within_3mm / static_cast<double>(all_reachable);
  return figures;
}

std::vector<Vector3d> SpreadOver(const geometry::Mesh& mesh, double spacing, std::uint64_t seed) {
  double area = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3f ab = mesh.vertices[t[1]] - mesh.vertices[t[0]];
    area += 0.5 * ab.cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).norm();
  }
  std::vector<Vector3d> points;
  if (!(area > 0.0)) return points;
  Rng rng(seed);
  const int count = std::max(1, static_cast<int>(area / (spacing * spacing)));
  for (const geometry::MeshSample& sample : geometry::SampleSurface(mesh, count, &rng)) {
    points.push_back(sample.surface.point.cast<double>());
  }
  return points;
}

}  // namespace secondlook::apps
