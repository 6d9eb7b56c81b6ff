#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <nanoflann.hpp>

namespace secondlook::geometry {

/// Nearest neighbours among points that do not change, all in one frame. Not copyable, as the index
/// refers to the points.
class KdTree {
 public:
  /// A neighbour: its index among the points, and the squared distance [m^2].
  struct Neighbour {
    int index{-1};  ///< -1: there are no points.
    float squared_distance{};
  };

  explicit KdTree(std::vector<Eigen::Vector3f> points)
      : cloud_{std::move(points)}, index_(3, cloud_, nanoflann::KDTreeSingleIndexAdaptorParams(8)) {
    if (!cloud_.points.empty()) index_.buildIndex();
  }
  KdTree(const KdTree&) = delete;
  KdTree& operator=(const KdTree&) = delete;

  const std::vector<Eigen::Vector3f>& points() const { return cloud_.points; }

  /// The point nearest to `query`.
  Neighbour Nearest(const Eigen::Vector3f& query) const {
    if (cloud_.points.empty()) return {};
    std::size_t index = 0;
    float squared = 0.0F;
    nanoflann::KNNResultSet<float> result(1);
    result.init(&index, &squared);
    index_.findNeighbors(result, query.data(), nanoflann::SearchParams());
    return {static_cast<int>(index), squared};
  }

 private:
  struct Cloud {
    std::vector<Eigen::Vector3f> points;
    std::size_t kdtree_get_point_count() const { return points.size(); }
    float kdtree_get_pt(std::size_t i, std::size_t axis) const {
      return points[i][static_cast<Eigen::Index>(axis)];
    }
    template <class Box>
    bool kdtree_get_bbox(Box& /*box*/) const {
      return false;
    }
  };
  using Index = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>,
                                                    Cloud, 3, std::size_t>;

  Cloud cloud_;
  Index index_;
};

}  // namespace secondlook::geometry
