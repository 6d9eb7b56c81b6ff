#include "lib/geometry/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace secondlook::geometry {
namespace {

/// The cell of `point` in a grid of `spacing`, 21 bits an axis.
std::uint64_t CellOf(const Eigen::Vector3f& point, double spacing) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = static_cast<std::int64_t>(std::floor(point[axis] / spacing));
    key = (key << 21U) | (static_cast<std::uint64_t>(cell + (1 << 20)) & 0x1fffffU);
  }
  return key;
}

}  // namespace

std::vector<MeshSample> SampleSurface(const Mesh& mesh, int count, Rng* rng) {
  std::vector<double> area_until(mesh.triangles.size());
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[i];
    const Eigen::Vector3f& a = mesh.vertices[t[0]];
    area += 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
    area_until[i] = area;
  }
  std::vector<MeshSample> samples;
  samples.reserve(static_cast<std::size_t>(count));
  std::size_t triangle = 0;
  for (int i = 0; i < count; ++i) {
    const double target = area * (i + rng->Uniform(0.0, 1.0)) / count;
    while (triangle + 1 < area_until.size() && area_until[triangle] < target) ++triangle;
    const double root = std::sqrt(rng->Uniform(0.0, 1.0));
    const double share = rng->Uniform(0.0, 1.0);
    MeshSample sample;
    sample.triangle = static_cast<int>(triangle);
    sample.weights = Eigen::Vector3d(1.0 - root, root * (1.0 - share), root * share).cast<float>();
    const Eigen::Vector3i& t = mesh.triangles[triangle];
    const Eigen::Vector3f& a = mesh.vertices[t[0]];
    const Eigen::Vector3f& b = mesh.vertices[t[1]];
    const Eigen::Vector3f& c = mesh.vertices[t[2]];
    sample.surface.point = sample.weights[0] * a + sample.weights[1] * b + sample.weights[2] * c;
    sample.surface.normal = (b - a).cross(c - a).normalized();
    samples.push_back(sample);
  }
  return samples;
}

std::vector<int> SubsampleByNormals(const std::vector<OrientedPoint>& points, double spacing,
                                    double angle) {
  std::vector<std::uint64_t> cells(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) cells[i] = CellOf(points[i].point, spacing);
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return cells[static_cast<std::size_t>(a)] < cells[static_cast<std::size_t>(b)];
  });
  const auto cosine = static_cast<float>(std::cos(angle));
  std::vector<int> kept;
  std::size_t group = 0;  // first kept index of the present cell
  std::uint64_t cell = 0;
  for (const int i : order) {
    const auto index = static_cast<std::size_t>(i);
    if (cells[index] != cell || kept.empty()) {
      cell = cells[index];
      group = kept.size();
    }
    const bool joins =
        std::any_of(kept.begin() + static_cast<std::ptrdiff_t>(group), kept.end(), [&](int k) {
          return points[static_cast<std::size_t>(k)].normal.dot(points[index].normal) > cosine;
        });
    if (!joins) kept.push_back(i);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

std::vector<Eigen::Vector3d> Thinned(std::vector<Eigen::Vector3d> points,
                                     const std::vector<Eigen::Vector3d>& more, double spacing) {
  points.insert(points.end(), more.begin(), more.end());
  std::vector<std::pair<std::array<int, 3>, int>> cells;
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    const Eigen::Vector3i c = (points[i] / spacing).array().floor().cast<int>();
    cells.push_back({{c.x(), c.y(), c.z()}, i});
  }
  std::sort(cells.begin(), cells.end());
  std::vector<int> kept;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].first != cells[i - 1].first) kept.push_back(cells[i].second);
  }
  std::sort(kept.begin(), kept.end());
  std::vector<Eigen::Vector3d> thinned;
  for (const int i : kept) thinned.push_back(points[i]);
  return thinned;
}

}  // namespace secondlook::geometry
