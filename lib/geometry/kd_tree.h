#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace secondlook::geometry {

/// A point of a KdTree, as a query found it.
struct Neighbour {
  int index{};                ///< Into the points the tree was built from.
  double squared_distance{};  ///< To the query [m^2].
};

/// Nearest-neighbour search over fixed points (nanoflann's k-d tree). Queries may run on several
/// threads at once.
class KdTree {
 public:
  /// A tree over `points`, all in one frame [m]. @pre every point is finite.
  explicit KdTree(std::vector<Eigen::Vector3d> points);
  ~KdTree();
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;

  const std::vector<Eigen::Vector3d>& points() const;

  /// The point nearest to `query` among those nearer than `max_distance` [m]; empty when there is
  /// none.
  std::optional<Neighbour> Nearest(const Eigen::Vector3d& query, double max_distance) const;

  /// The `count` nearest points, nearest first; fewer when the tree holds fewer. @pre count >= 1.
  std::vector<Neighbour> Nearest(const Eigen::Vector3d& query, int count) const;

  /// All points nearer than `radius` [m], nearest first.
  std::vector<Neighbour> Within(const Eigen::Vector3d& query, double radius) const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace secondlook::geometry
