#include "lib/geometry/kd_tree.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include <nanoflann.hpp>

namespace secondlook::geometry {
namespace {

/// What nanoflann asks of a container of points.
struct Points {
  std::vector<Eigen::Vector3d> p;

  std::size_t kdtree_get_point_count() const { return p.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return p[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>,
                                                 Points, 3, std::uint32_t>;

}  // namespace

struct KdTree::Index {
  explicit Index(std::vector<Eigen::Vector3d> p) : points{std::move(p)}, tree(3, points) {}

  Points points;
  Tree tree;
};

KdTree::KdTree(std::vector<Eigen::Vector3d> points)
    : index_(std::make_unique<Index>(std::move(points))) {}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;

const std::vector<Eigen::Vector3d>& KdTree::points() const { return index_->points.p; }

std::optional<Neighbour> KdTree::Nearest(const Eigen::Vector3d& query, double max_distance) const {
  if (points().empty()) return std::nullopt;
  std::uint32_t nearest = 0;
  double squared = 0.0;
  nanoflann::KNNResultSet<double, std::uint32_t> result(1);
  result.init(&nearest, &squared);
  squared = max_distance * max_distance;  // the worst distance still of interest, from the start
  index_->tree.findNeighbors(result, query.data(), nanoflann::SearchParams());
  if (result.size() == 0) return std::nullopt;
  return Neighbour{static_cast<int>(nearest), squared};
}

std::vector<Neighbour> KdTree::Nearest(const Eigen::Vector3d& query, int count) const {
  const auto wanted = std::min(static_cast<std::size_t>(count), points().size());
  if (wanted == 0) return {};
  std::vector<std::uint32_t> indices(wanted);
  std::vector<double> squared(wanted);
  nanoflann::KNNResultSet<double, std::uint32_t> result(wanted);
  result.init(indices.data(), squared.data());
  index_->tree.findNeighbors(result, query.data(), nanoflann::SearchParams());
  std::vector<Neighbour> neighbours;
  for (std::size_t i = 0; i < result.size(); ++i) {
    neighbours.push_back({static_cast<int>(indices[i]), squared[i]});
  }
  return neighbours;
}

std::vector<Neighbour> KdTree::Within(const Eigen::Vector3d& query, double radius) const {
  if (points().empty()) return {};
  std::vector<std::pair<std::uint32_t, double>> found;
  index_->tree.radiusSearch(query.data(), radius * radius, found,
                            nanoflann::SearchParams(32, 0.0F, false));
  std::vector<Neighbour> neighbours;
  for (const auto& [index, squared] : found) {
    neighbours.push_back({static_cast<int>(index), squared});
  }
  std::sort(neighbours.begin(), neighbours.end(), [](const Neighbour& a, const Neighbour& b) {
    return std::pair(a.squared_distance, a.index) < std::pair(b.squared_distance, b.index);
  });
  return neighbours;
}

}  // namespace secondlook::geometry
