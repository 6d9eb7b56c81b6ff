#include "lib/geometry/thin_out.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "lib/common/error.h"

namespace secondlook::geometry {
namespace {

using Cell = std::array<int, 3>;

Cell CellOf(const Eigen::Vector3f& p, double size) {
  return {static_cast<int>(std::floor(p.x() / size)), static_cast<int>(std::floor(p.y() / size)),
          static_cast<int>(std::floor(p.z() / size))};
}

/// The means of the `values` that became each of `count` vertices; empty when there are none.
template <class Vector>
std::vector<Vector> Means(const std::vector<Vector>& values, const std::vector<int>& becomes,
                          const std::vector<int>& members) {
  if (values.empty()) return {};
  std::vector<Vector> means(members.size(), Vector::Zero());
  for (std::size_t v = 0; v < values.size(); ++v) means[becomes[v]] += values[v];
  for (std::size_t i = 0; i < members.size(); ++i) means[i] /= static_cast<float>(members[i]);
  return means;
}

/// The same triangle whichever of its corners comes first.
std::array<int, 3> FromLowest(const std::array<int, 3>& t) {
  const auto lowest = std::min_element(t.begin(), t.end()) - t.begin();
  return {t[lowest], t[(lowest + 1) % 3], t[(lowest + 2) % 3]};
}

}  // namespace

Mesh ThinOut(const Mesh& mesh, double cell) {
  if (!(cell > 0.0)) Throw<InvalidArgument>("a mesh is thinned out to cells of {} m", cell);
  std::map<Cell, int> vertex_in;
  std::vector<int> becomes;
  std::vector<int> members;
  for (const Eigen::Vector3f& p : mesh.vertices) {
    const auto [at, is_new] =
        vertex_in.try_emplace(CellOf(p, cell), static_cast<int>(members.size()));
    if (is_new) members.push_back(0);
    ++members[at->second];
    becomes.push_back(at->second);
  }
  Mesh thin;
  thin.materials = mesh.materials;
  thin.vertices = Means(mesh.vertices, becomes, members);
  thin.vertex_colors = Means(mesh.vertex_colors, becomes, members);
  thin.uv = Means(mesh.uv, becomes, members);
  std::set<std::array<int, 3>> there;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[i];
    const std::array<int, 3> corners{becomes[t[0]], becomes[t[1]], becomes[t[2]]};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    if (!there.insert(FromLowest(corners)).second) continue;
    thin.triangles.emplace_back(corners[0], corners[1], corners[2]);
    if (!mesh.triangle_material.empty()) {
      thin.triangle_material.push_back(mesh.triangle_material[i]);
    }
  }
  return thin;
}

}  // namespace secondlook::geometry
