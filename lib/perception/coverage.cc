#include "lib/perception/coverage.h"

#include <algorithm>

#include "lib/geometry/mesh_border.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;

/// A surface that still opens where it ends is thought to have reached its widest place there.
constexpr double kMinCosine = 0.0;
/// What faces the support so much, nobody above it sees at a useful incidence.
constexpr double kDown = -0.7;
/// The direction of a jagged border is that between so many vertices before and behind.
constexpr int kStretch = 3;

}  // namespace

std::vector<HoleTriangle> FillHoles(const world::PartialMesh& surface,
                                    const world::SupportPlane& plane_W, double footing) {
  std::vector<HoleTriangle> triangles;
  const auto vertex = [&](int i) { return Vector3d(surface.mesh.vertices[i].cast<double>()); };
  for (const std::vector<int>& loop : geometry::BorderLoops(surface.mesh)) {
    const int count = static_cast<int>(loop.size());
    const auto at = [&](int i) { return vertex(loop[(i % count + count) % count]); };
    Vector3d middle = Vector3d::Zero();
    double length = 0.0;
    for (int i = 0; i < count; ++i) {
      const double edge = (at(i + 1) - at(i)).norm();
      middle += 0.5 * edge * (at(i + 1) + at(i));
      length += edge;
    }
    if (!(length > 0.0)) continue;
    middle /= length;
    for (int i = 0; i < count; ++i) {
      HoleTriangle triangle{at(i), at(i + 1), middle};
      triangle.area = 0.5 * (triangle.a - middle).cross(triangle.b - middle).norm();
      const bool stands =
          std::max(plane_W.HeightOf(triangle.a), plane_W.HeightOf(triangle.b)) < footing;
      if (stands || triangle.Normal().dot(plane_W.normal_A) < kDown) {
        triangle.bulge = 0.0;
      } else {
        const Vector3d along = (at(i + 1 + kStretch) - at(i - kStretch)).normalized();
        const Vector3d outward = along.cross(surface.normals[loop[i]].cast<double>()).normalized();
        Vector3d inward = middle - 0.5 * (triangle.a + triangle.b);
        inward -= inward.dot(along) * along;
        const double cosine = inward.norm() > 0.0 ? outward.dot(inward.normalized()) : 1.0;
        triangle.bulge = 2.0 / (1.0 + std::max(cosine, kMinCosine));
      }
      triangles.push_back(triangle);
    }
  }
  return triangles;
}

Coverage EstimateCoverage(const world::PartialMesh& surface, const world::SupportPlane& plane_W,
                          double footing) {
  Coverage coverage;
  for (const Eigen::Vector3i& t : surface.mesh.triangles) {
    const Eigen::Vector3f& a = surface.mesh.vertices[t[0]];
    const Vector3d ab = (surface.mesh.vertices[t[1]] - a).cast<double>();
    const Vector3d ac = (surface.mesh.vertices[t[2]] - a).cast<double>();
    coverage.filled += 0.5 * ab.cross(ac).norm();
  }
  for (const HoleTriangle& triangle : FillHoles(surface, plane_W, footing)) {
    coverage.holes += triangle.area;
    coverage.unseen += triangle.bulge * triangle.area;
  }
  return coverage;
}

world::PartialMesh Part(const world::PartialMesh& surface, const std::vector<char>& kept) {
  world::PartialMesh part;
  part.mesh.materials = surface.mesh.materials;
  const bool colored = !surface.mesh.vertex_colors.empty();
  std::vector<int> index(kept.size(), -1);
  for (const Eigen::Vector3i& t : surface.mesh.triangles) {
    if (kept[t[0]] == 0 || kept[t[1]] == 0 || kept[t[2]] == 0) continue;
    Eigen::Vector3i triangle;
    for (int k = 0; k < 3; ++k) {
      int& i = index[t[k]];
      if (i < 0) {
        i = static_cast<int>(part.mesh.vertices.size());
        part.mesh.vertices.push_back(surface.mesh.vertices[t[k]]);
        part.normals.push_back(surface.normals[t[k]]);
        part.density.push_back(surface.density[t[k]]);
        if (colored) part.mesh.vertex_colors.push_back(surface.mesh.vertex_colors[t[k]]);
      }
      triangle[k] = i;
    }
    part.mesh.triangles.push_back(triangle);
  }
  part.mesh.triangle_material.assign(part.mesh.triangles.size(), 0);
  return part;
}

world::PartialMesh Above(const world::PartialMesh& surface, const world::SupportPlane& plane_W,
                         double height) {
  std::vector<char> high(surface.mesh.vertices.size(), 0);
  for (std::size_t i = 0; i < high.size(); ++i) {
    high[i] = plane_W.HeightOf(surface.mesh.vertices[i].cast<double>()) > height ? 1 : 0;
  }
  return Part(surface, high);
}

}  // namespace secondlook::perception
