#include "lib/perception/point_voxels.h"

namespace secondlook::perception {
namespace {

std::int64_t KeyOf(const Eigen::Vector3i& cell) {
  constexpr std::int64_t kBias = 1 << 20;
  return ((cell.x() + kBias) << 42) | ((cell.y() + kBias) << 21) | (cell.z() + kBias);
}

}  // namespace

PointVoxels::PointVoxels(const std::vector<Eigen::Vector3d>& points, double cell) {
  std::vector<int> counts;
  voxel_of_.reserve(points.size());
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3i c = (p / cell).array().floor().cast<int>();
    const auto [entry, is_new] = index_.try_emplace(KeyOf(c), size());
    if (is_new) {
      cells_.push_back(c);
      means_.emplace_back(Eigen::Vector3d::Zero());
      counts.push_back(0);
    }
    means_[entry->second] += p;
    ++counts[entry->second];
    voxel_of_.push_back(entry->second);
  }
  for (int i = 0; i < size(); ++i) means_[i] /= counts[i];
}

std::vector<int> PointVoxels::Neighbours(int i, int reach, double distance) const {
  std::vector<int> found;
  Eigen::Vector3i step;
  for (step.z() = -reach; step.z() <= reach; ++step.z()) {
    for (step.y() = -reach; step.y() <= reach; ++step.y()) {
      for (step.x() = -reach; step.x() <= reach; ++step.x()) {
        const auto entry = index_.find(KeyOf(cells_[i] + step));
        if (entry == index_.end() || entry->second == i) continue;
        if ((means_[entry->second] - means_[i]).norm() < distance) found.push_back(entry->second);
      }
    }
  }
  return found;
}

std::vector<int> ConnectedComponents(const std::vector<std::vector<int>>& neighbours) {
  std::vector<int> labels(neighbours.size(), -1);
  int next = 0;
  std::vector<int> open;
  for (int start = 0; start < static_cast<int>(neighbours.size()); ++start) {
    if (labels[start] >= 0) continue;
    labels[start] = next;
    open = {start};
    while (!open.empty()) {
      const int i = open.back();
      open.pop_back();
      for (const int j : neighbours[i]) {
        if (labels[j] >= 0) continue;
        labels[j] = next;
        open.push_back(j);
      }
    }
    ++next;
  }
  return labels;
}

}  // namespace secondlook::perception
