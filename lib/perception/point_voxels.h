#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace secondlook::perception {

/// Points gathered in the cells of a cubic grid: those cells only that hold any, in the order in
/// which the points first meet them.
class PointVoxels {
 public:
  /// @pre cell > 0; the points lie within a million cells of the origin.
  PointVoxels(const std::vector<Eigen::Vector3d>& points, double cell);

  int size() const { return static_cast<int>(means_.size()); }

  /// The mean of the points in voxel `i`.
  const Eigen::Vector3d& mean(int i) const { return means_[i]; }

  /// The voxel of each point.
  const std::vector<int>& voxel_of() const { return voxel_of_; }

  /// Other voxels at most `reach` cells away in each direction whose means lie nearer than
  /// `distance` [m], in a fixed order.
  std::vector<int> Neighbours(int i, int reach, double distance) const;

 private:
  std::vector<Eigen::Vector3i> cells_;
  std::vector<Eigen::Vector3d> means_;
  std::vector<int> voxel_of_;
  std::unordered_map<std::int64_t, int>
      index_;  // for look-up only; the order is that of the points
};

/// For each node of a graph, a label from 0 that it shares with all that it is connected to; labels
/// count in the order of the nodes. `neighbours[i]` are the nodes joined to i.
std::vector<int> ConnectedComponents(const std::vector<std::vector<int>>& neighbours);

}  // namespace secondlook::perception
