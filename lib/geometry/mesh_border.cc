#include "lib/geometry/mesh_border.h"

#include <algorithm>
#include <array>

namespace secondlook::geometry {

std::vector<std::vector<int>> BorderLoops(const Mesh& mesh) {
  struct Edge {
    int low, high;  // its vertices in order, and the way it is used
    int from, to;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int from = triangle[k];
      const int to = triangle[(k + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), from, to});
    }
  }
  const auto key = [](const Edge& e) { return std::array<int, 2>{e.low, e.high}; };
  std::sort(edges.begin(), edges.end(),
            [&](const Edge& a, const Edge& b) { return key(a) < key(b); });
  std::vector<std::array<int, 2>> border;  // from, to
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && key(edges[end]) == key(edges[i])) ++end;
    if (end - i == 1) border.push_back({edges[i].from, edges[i].to});
    i = end;
  }
  std::sort(border.begin(), border.end());

  std::vector<char> used(border.size(), 0);
  std::vector<std::vector<int>> loops;
  for (std::size_t start = 0; start < border.size(); ++start) {
    std::vector<int> loop;
    for (std::size_t edge = start; edge < border.size() && used[edge] == 0;) {
      used[edge] = 1;
      loop.push_back(border[edge][0]);
      // An unused edge that goes on from where this one ends.
      const std::array<int, 2> next = {border[edge][1], 0};
      edge = std::lower_bound(border.begin(), border.end(), next) - border.begin();
      while (edge < border.size() && border[edge][0] == next[0] && used[edge] != 0) ++edge;
      if (edge < border.size() && border[edge][0] != next[0]) break;
    }
    if (loop.size() >= 3) loops.push_back(std::move(loop));
  }
  return loops;
}

}  // namespace secondlook::geometry
