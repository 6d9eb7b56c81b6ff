#include "sim/shaded_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace secondlook::sim {
namespace {

using geometry::Mesh;

/// For each vertex the number of its position, equal for vertices at the same place.
std::vector<int> NumberPositions(const Mesh& mesh) {
  std::vector<int> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto less = [&](int a, int b) {
    const Eigen::Vector3f& p = mesh.vertices[a];
    const Eigen::Vector3f& q = mesh.vertices[b];
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
  };
  std::sort(order.begin(), order.end(), less);
  std::vector<int> numbers(order.size());
  int number = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && less(order[i - 1], order[i])) ++number;
    numbers[order[i]] = number;
  }
  return numbers;
}

/// The triangles around each position: those of position p are at [begin[p], begin[p + 1]).
struct Neighbours {
  std::vector<int> begin;
  std::vector<int> triangles;
};

Neighbours FindNeighbours(const Mesh& mesh, const std::vector<int>& positions) {
  Neighbours around;
  around.begin.assign(mesh.vertices.size() + 1, 0);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++around.begin[positions[t[k]] + 1];
  }
  std::partial_sum(around.begin.begin(), around.begin.end(), around.begin.begin());
  std::vector<int> next = around.begin;
  around.triangles.resize(3 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      around.triangles[next[positions[mesh.triangles[i][k]]]++] = static_cast<int>(i);
    }
  }
  return around;
}

/// Twice the area of each triangle along its normal.
std::vector<Eigen::Vector3f> AreaNormals(const Mesh& mesh) {
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(mesh.triangles.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3f& a = mesh.vertices[t[0]];
    normals.push_back((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a));
  }
  return normals;
}

ShadedVertex MakeVertex(const Mesh& mesh, int vertex, const Eigen::Vector3f& normal) {
  ShadedVertex out{};
  Eigen::Map<Eigen::Vector3f>(out.position) = mesh.vertices[vertex];
  Eigen::Map<Eigen::Vector3f>(out.normal) = normal;
  if (!mesh.uv.empty()) Eigen::Map<Eigen::Vector2f>(out.uv) = mesh.uv[vertex];
  for (int k = 0; k < 3; ++k) {
    out.color[k] =
        mesh.vertex_colors.empty() ? 1.0F : LinearFromSrgb(mesh.vertex_colors[vertex][k]);
  }
  return out;
}

/// Adds vertices, each pair of vertex and normal once.
class VertexPool {
 public:
  VertexPool(const Mesh& mesh, ShadedMesh* out)
      : mesh_(mesh), out_(out), first_(mesh.vertices.size(), -1) {}

  std::uint32_t Add(int vertex, const Eigen::Vector3f& normal) {
    for (int i = first_[vertex]; i >= 0; i = next_[i]) {
      const Eigen::Map<const Eigen::Vector3f> other(out_->vertices[i].normal);
      if ((other - normal).squaredNorm() < 1e-8F) return static_cast<std::uint32_t>(i);
    }
    next_.push_back(first_[vertex]);
    first_[vertex] = static_cast<int>(out_->vertices.size());
    out_->vertices.push_back(MakeVertex(mesh_, vertex, normal));
    return static_cast<std::uint32_t>(first_[vertex]);
  }

 private:
  const Mesh& mesh_;
  ShadedMesh* out_;
  std::vector<int> first_;  ///< Of each vertex of the mesh, into `out_->vertices`, or -1.
  std::vector<int> next_;   ///< The same vertex with another normal, or -1.
};

std::vector<int> OrderByMaterial(const Mesh& mesh) {
  std::vector<int> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return mesh.triangle_material[a] < mesh.triangle_material[b];
  });
  return order;
}

}  // namespace

ShadedMesh Shade(const Mesh& mesh, double crease) {
  const float min_cosine = static_cast<float>(std::cos(crease));
  const std::vector<int> positions = NumberPositions(mesh);
  const Neighbours around = FindNeighbours(mesh, positions);
  const std::vector<Eigen::Vector3f> areas = AreaNormals(mesh);
  ShadedMesh shaded;
  VertexPool pool(mesh, &shaded);
  for (const int i : OrderByMaterial(mesh)) {
    const std::uint16_t material = mesh.triangle_material[i];
    if (shaded.ranges.empty() || shaded.ranges.back().material != material) {
      shaded.ranges.push_back({material, static_cast<int>(shaded.indices.size()), 0});
    }
    for (const int vertex : mesh.triangles[i]) {
      const int position = positions[vertex];
      Eigen::Vector3f normal = Eigen::Vector3f::Zero();
      for (int n = around.begin[position]; n < around.begin[position + 1]; ++n) {
        const Eigen::Vector3f& other = areas[around.triangles[n]];
        if (areas[i].dot(other) >= min_cosine * areas[i].norm() * other.norm()) normal += other;
      }
      shaded.indices.push_back(pool.Add(vertex, normal.normalized()));
      ++shaded.ranges.back().count;
    }
  }
  return shaded;
}

float LinearFromSrgb(float value) {
  return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}

}  // namespace secondlook::sim
