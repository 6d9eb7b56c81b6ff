#include "lib/planning/boundary_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Cholesky>

#include "lib/common/check_range.h"
#include "lib/geometry/kd_tree.h"
#include "lib/geometry/mesh_border.h"
#include "lib/perception/coverage.h"
#include "lib/world/ray_cast.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;
/// Fewer vertices tell no curvature.
constexpr int kMinVertices = 12;
/// The surface is not thought to turn by more than this beyond its border.
constexpr double kMaxTurn = 80.0 * kDegree;
/// Multiples of it are spread evenly over [0, 1), leaving whole numbers out.
constexpr double kGolden = std::numbers::phi - 1.0;

/// The surface at a place of its border.
struct BorderPlace {
  Vector3d p_W;
  Vector3d normal_W;
  Vector3d outward_W;  ///< Along the surface, away from it.
};

/// The slope and curvature of the surface along `outward_W`, by a quadratic patch over the vertices
/// around it.
std::optional<SurfaceTrend> FollowTrend(const BorderPlace& place, const world::PartialMesh& surface,
                                        const geometry::KdTree& tree, double radius, double reach) {
  const Vector3d side_W = place.normal_W.cross(place.outward_W);
  Eigen::Matrix<double, 6, 6> square = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> product = Eigen::Matrix<double, 6, 1>::Zero();
  int vertices = 0;
  for (const geometry::Neighbour& neighbour : tree.Within(place.p_W, radius)) {
    if (surface.normals[neighbour.index].cast<double>().dot(place.normal_W) < 0.0) continue;
    const Vector3d arm = (tree.points()[neighbour.index] - place.p_W) / radius;
    const double u = arm.dot(place.outward_W);
    const double v = arm.dot(side_W);
    Eigen::Matrix<double, 6, 1> row;
    row << 1.0, u, v, u * u, u * v, v * v;
    square += row * row.transpose();
    product += arm.dot(place.normal_W) * row;
    ++vertices;
  }
  if (vertices < kMinVertices) return std::nullopt;
  square.diagonal().array() += 1e-3 * vertices;  // what little says nothing stays flat
  const Eigen::Matrix<double, 6, 1> patch = square.ldlt().solve(product);
  const double slope = patch[1];
  const Vector3d along_W = (place.outward_W + slope * place.normal_W).normalized();
  const Vector3d up_W = (place.normal_W - slope * place.outward_W).normalized();
  const double curvature = 2.0 * patch[3] / radius / std::pow(1.0 + slope * slope, 1.5);
  const double turn = std::clamp(curvature * reach, -kMaxTurn, kMaxTurn);
  SurfaceTrend trend;  // along the arc that turns so far
  const double flat = std::abs(turn) < 1e-6 ? 1.0 : std::sin(turn) / turn;
  const double rise = std::abs(turn) < 1e-6 ? 0.0 : (1.0 - std::cos(turn)) / turn;
  trend.p_W = place.p_W + reach * (flat * along_W + rise * up_W);
  trend.normal_W = (std::cos(turn) * up_W - std::sin(turn) * along_W).normalized();
  return trend;
}

/// Directions around `normal`, the most upright first.
std::vector<Vector3d> DirectionsAround(const Vector3d& normal, double max_angle) {
  constexpr int kRings = 4;
  constexpr int kAround = 8;
  const Vector3d u = normal.unitOrthogonal();
  const Vector3d v = normal.cross(u);
  std::vector<Vector3d> directions{normal};
  for (int ring = 1; ring <= kRings; ++ring) {
    const double tilt = max_angle * ring / kRings;
    for (int k = 0; k < kAround; ++k) {
      const double a = 2.0 * std::numbers::pi * (k + 0.5 * (ring % 2)) / kAround;
      directions.push_back(std::cos(tilt) * normal +
                           std::sin(tilt) * (std::cos(a) * u + std::sin(a) * v));
    }
  }
  return directions;
}

/// Nothing known to be occupied is within `clearance` of the point.
bool IsClear(const world::BrickGrid& grid, const Vector3d& p_W, double clearance) {
  for (const Vector3d& way : DirectionsAround(Vector3d::UnitZ(), std::numbers::pi)) {
    for (const double share : {0.0, 0.5, 1.0}) {
      if (grid.At(p_W + share * clearance * way) == world::Occupancy::kOccupied) return false;
    }
  }
  return true;
}

/// The share of what lies around `trend` that something occupied hides from `p_WC`.
double Occlusion(const SurfaceTrend& trend, const Vector3d& p_WC, double radius,
                 const world::BrickGrid& grid, const world::LeapField& leaps) {
  const Vector3d u = trend.normal_W.unitOrthogonal();
  const Vector3d v = trend.normal_W.cross(u);
  // What is occupied so near to the point is the surface itself.
  const Vector3d before = 1.5 * grid.voxel() * (p_WC - trend.p_W).normalized();
  int blocked = 0;
  const std::vector<Vector3d> offsets = {Vector3d::Zero(), radius * u, -radius * u, radius * v,
                                         -radius * v};
  for (const Vector3d& offset : offsets) {
    const world::RayEnd end = world::CastRay(grid, leaps, p_WC, trend.p_W + offset + before);
    blocked += end.state == world::Occupancy::kOccupied ? 1 : 0;
  }
  return static_cast<double>(blocked) / static_cast<double>(offsets.size());
}

}  // namespace

void BoundarySearchConfig::Validate() const {
  CheckRange(spacing_m, 1e-4, 1.0, "spacing_m");
  CheckRange(patch_radius_m, 1e-3, 1.0, "patch_radius_m");
  CheckRange(reach_m, 1e-3, 1.0, "reach_m");
  CheckRange(footing_m, 0.0, 0.1, "footing_m");
  CheckRange(distance_m, 0.01, 5.0, "distance_m");
  CheckRange(max_incidence_deg, 1.0, 85.0, "max_incidence_deg");
  CheckRange(clearance_m, 0.0, 1.0, "clearance_m");
  CheckRange(max_occlusion, 0.0, 1.0, "max_occlusion");
  CheckRange(most, 1, 100000, "most");
}

std::vector<SurfaceTrend> FindTrends(const world::PartialMesh& surface,
                                     const world::SupportPlane& plane_W,
                                     const BoundarySearchConfig& config) {
  config.Validate();
  std::vector<SurfaceTrend> trends;
  if (surface.mesh.empty()) return trends;
  std::vector<Vector3d> vertices_W;
  for (const Eigen::Vector3f& vertex : surface.mesh.vertices) {
    vertices_W.push_back(vertex.cast<double>());
  }
  const geometry::KdTree tree(vertices_W);
  for (const std::vector<int>& loop : geometry::BorderLoops(surface.mesh)) {
    const int count = static_cast<int>(loop.size());
    const auto at = [&](int i) { return vertices_W[loop[(i % count + count) % count]]; };
    double length = 0.0;
    for (int i = 0; i < count; ++i) length += (at(i + 1) - at(i)).norm();
    if (length < config.spacing_m) continue;  // a hole that a pixel left
    // A border is jagged as the voxels are: its direction is that of a stretch of it.
    const int stretch = std::max(
        1, std::min(count / 4, static_cast<int>(std::ceil(config.spacing_m * count / length))));
    double since = config.spacing_m;
    for (int i = 0; i < count; ++i) {
      since += (at(i) - at(i - 1)).norm();
      if (since < config.spacing_m || plane_W.HeightOf(at(i)) < config.footing_m) continue;
      BorderPlace place;
      place.p_W = at(i);
      place.normal_W = surface.normals[loop[i]].cast<double>();
      place.outward_W = (at(i + stretch) - at(i - stretch)).cross(place.normal_W);
      if (!(place.outward_W.norm() > 1e-9)) continue;
      place.outward_W.normalize();
      std::optional<SurfaceTrend> trend =
          FollowTrend(place, surface, tree, config.patch_radius_m, config.reach_m);
      if (!trend || plane_W.HeightOf(trend->p_W) < 0.0) continue;
      since = 0.0;
      trend->border = length;
      trends.push_back(*trend);
    }
  }
  return trends;
}

std::vector<SurfaceTrend> TrendsAcrossHoles(const world::PartialMesh& surface,
                                            const world::SupportPlane& plane_W,
                                            const BoundarySearchConfig& config) {
  config.Validate();
  const double share = config.spacing_m * config.spacing_m;
  std::vector<SurfaceTrend> trends;
  double since = 0.0;
  for (const perception::HoleTriangle& hole :
       perception::FillHoles(surface, plane_W, config.footing_m)) {
    if (!(hole.bulge > 0.0)) continue;
    // The triangles of a fan are slender, so that a line through each tells where.
    const Vector3d edge = 0.5 * (hole.a + hole.b);
    for (since += hole.area; since >= share; since -= share) {
      const double turn = kGolden * static_cast<double>(trends.size());
      const double away = std::sqrt(turn - std::floor(turn));  // evenly over the area
      trends.push_back({hole.middle + away * (edge - hole.middle), hole.Normal(), 0.0});
    }
  }
  return trends;
}

std::vector<ScanCandidate> CandidateScans(const std::vector<SurfaceTrend>& trends,
                                          const world::BrickGrid& grid,
                                          const world::LeapField& leaps,
                                          const world::SupportPlane& plane_W,
                                          const BoundarySearchConfig& config) {
  config.Validate();
  std::vector<ScanCandidate> candidates;
  for (int t = 0; t < static_cast<int>(trends.size()); ++t) {
    const SurfaceTrend& trend = trends[t];
    std::optional<ScanCandidate> best;
    for (const Vector3d& way :
         DirectionsAround(trend.normal_W, config.max_incidence_deg * kDegree)) {
      const Vector3d p_WC = trend.p_W + config.distance_m * way;
      if (way.head<2>().norm() < 1e-3) continue;  // LookAt() needs a side
      if (plane_W.HeightOf(p_WC) < config.clearance_m) continue;
      const double occlusion = Occlusion(trend, p_WC, 0.5 * config.reach_m, grid, leaps);
      if (occlusion > config.max_occlusion || (best && occlusion >= best->occlusion)) continue;
      if (!IsClear(grid, p_WC, config.clearance_m)) continue;
      best = {LookAt(p_WC, trend.p_W), t, occlusion};
      if (occlusion == 0.0) break;  // those that follow are less upright
    }
    if (best) candidates.push_back(*best);
  }
  if (static_cast<int>(candidates.size()) > config.most) {
    std::vector<ScanCandidate> kept;
    for (int i = 0; i < config.most; ++i) {
      kept.push_back(candidates[i * candidates.size() / config.most]);
    }
    candidates = std::move(kept);
  }
  return candidates;
}

}  // namespace secondlook::planning
