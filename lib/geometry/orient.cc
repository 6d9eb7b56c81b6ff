#include "lib/geometry/orient.h"

#include <array>
#include <utility>
#include <vector>

#include "lib/geometry/ray_caster.h"

namespace secondlook::geometry {
namespace {

/// Ways out of the surface, the first along the normal and five around it at 60 degrees.
constexpr std::array<std::array<float, 3>, 6> kWays{{{1.0F, 0.0F, 0.0F},
                                                     {0.5F, 0.866F, 0.0F},
                                                     {0.5F, 0.268F, 0.824F},
                                                     {0.5F, -0.701F, 0.509F},
                                                     {0.5F, -0.701F, -0.509F},
                                                     {0.5F, 0.268F, -0.824F}}};

/// Those of `triangles` whose back sees more of the outside than their front.
std::vector<int> WrongWayOf(const Mesh& mesh, const RayCaster& caster,
                            const std::vector<int>& triangles) {
  const auto offset = static_cast<float>(1e-4 * Diameter(mesh));
  std::vector<Ray> rays;
  rays.reserve(2 * kWays.size() * triangles.size());
  for (const int index : triangles) {
    const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(index)];
    const Eigen::Vector3f& a = mesh.vertices[t[0]];
    const Eigen::Vector3f& b = mesh.vertices[t[1]];
    const Eigen::Vector3f& c = mesh.vertices[t[2]];
    const Eigen::Vector3f normal = (b - a).cross(c - a).normalized();
    const Eigen::Vector3f side = normal.unitOrthogonal();
    const Eigen::Vector3f other = normal.cross(side);
    for (const float sign : {1.0F, -1.0F}) {
      const Eigen::Vector3f start = (a + b + c) / 3.0F + sign * offset * normal;
      for (const auto& [out, along, across] : kWays) {
        rays.push_back({start, sign * out * normal + along * side + across * other});
      }
    }
  }
  const std::vector<RayHit> hits = caster.Cast(rays);
  std::vector<int> wrong;
  std::size_t at = 0;
  for (const int index : triangles) {
    std::array<int, 2> escaped{};
    for (int& count : escaped) {
      for (std::size_t k = 0; k < kWays.size(); ++k) count += hits[at++].triangle < 0 ? 1 : 0;
    }
    if (escaped[1] > escaped[0]) wrong.push_back(index);
  }
  return wrong;
}

/// Every `step`-th triangle.
std::vector<int> Every(int step, const Mesh& mesh) {
  std::vector<int> triangles;
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); i += step) triangles.push_back(i);
  return triangles;
}

}  // namespace

int OrientOutward(Mesh* mesh) {
  constexpr std::size_t kProbes = 500;
  constexpr double kFew = 0.02;
  const RayCaster caster(*mesh);
  // Most meshes are right: a part of the triangles tells.
  const int step = static_cast<int>(mesh->triangles.size() / kProbes);
  if (step > 1) {
    const std::vector<int> probes = Every(step, *mesh);
    const std::vector<int> wrong = WrongWayOf(*mesh, caster, probes);
    if (static_cast<double>(wrong.size()) < kFew * static_cast<double>(probes.size())) return 0;
  }
  const std::vector<int> wrong = WrongWayOf(*mesh, caster, Every(1, *mesh));
  for (const int index : wrong) {
    Eigen::Vector3i& t = mesh->triangles[static_cast<std::size_t>(index)];
    std::swap(t[1], t[2]);
  }
  return static_cast<int>(wrong.size());
}

}  // namespace secondlook::geometry
