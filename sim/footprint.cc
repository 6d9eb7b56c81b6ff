#include "sim/footprint.h"

#include <algorithm>
#include <limits>

namespace secondlook::sim {
namespace {

using Eigen::Vector2d;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

Vector2d NearestOnSegment(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  const Vector2d ab = b - a;
  const double length = ab.squaredNorm();
  if (length == 0.0) return a;
  return a + std::clamp((p - a).dot(ab) / length, 0.0, 1.0) * ab;
}

bool Contains(const std::vector<Vector2d>& hull, const Vector2d& p) {
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d& from = hull[i];
    if (Cross(hull[(i + 1) % hull.size()] - from, p - from) < 0.0) return false;
  }
  return hull.size() > 2;
}

}  // namespace

std::vector<Vector2d> ConvexHull(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vector2d> hull;
  const auto add = [&](const Vector2d& p, std::size_t keep) {
    while (hull.size() >= keep + 2 &&
           Cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0.0) {
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const Vector2d& p : points) add(p, 0);
  const std::size_t lower = hull.size() - 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  hull.pop_back();  // the first point again
  return hull;
}

Footprint MakeFootprint(const std::string& name, const geometry::Mesh& mesh, const Pose& X_WM) {
  std::vector<Vector2d> points;
  points.reserve(mesh.vertices.size());
  for (const Eigen::Vector3f& p_MV : mesh.vertices) {
    points.emplace_back((X_WM * p_MV.cast<double>()).head<2>());
  }
  Footprint footprint{name, ConvexHull(std::move(points)), {0.0, 0.0}, 0.0};
  for (const Vector2d& p : footprint.hull_W) footprint.center_W += p;
  footprint.center_W /= static_cast<double>(footprint.hull_W.size());
  for (const Vector2d& p : footprint.hull_W) {
    footprint.bound = std::max(footprint.bound, (p - footprint.center_W).norm());
  }
  return footprint;
}

Nearest NearestOfSegment(const Vector2d& a, const Vector2d& b, const Vector2d& c,
                         const Vector2d& d) {
  const double across = Cross(b - a, d - c);
  if (across != 0.0) {
    const double s = Cross(c - a, d - c) / across;
    const double t = Cross(c - a, b - a) / across;
    if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) return {0.0, a + s * (b - a)};
  }
  Nearest nearest{std::numeric_limits<double>::infinity(), c};
  const auto consider = [&](const Vector2d& on_first, const Vector2d& on_second) {
    const double distance = (on_first - on_second).norm();
    if (distance < nearest.distance) nearest = {distance, on_second};
  };
  consider(a, NearestOnSegment(c, d, a));
  consider(b, NearestOnSegment(c, d, b));
  consider(NearestOnSegment(a, b, c), c);
  consider(NearestOnSegment(a, b, d), d);
  return nearest;
}

Nearest NearestOf(const Footprint& footprint, const Vector2d& a, const Vector2d& b) {
  const std::vector<Vector2d>& hull = footprint.hull_W;
  if (Contains(hull, a)) return {0.0, a};
  Nearest nearest{std::numeric_limits<double>::infinity(), hull.front()};
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Nearest edge = NearestOfSegment(a, b, hull[i], hull[(i + 1) % hull.size()]);
    if (edge.distance < nearest.distance) nearest = edge;
  }
  return nearest;
}

}  // namespace secondlook::sim
