#include "lib/perception/split.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "lib/common/error.h"
#include "lib/perception/point_voxels.h"
#include "lib/perception/surface.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;

using Graph = std::vector<std::vector<int>>;

/// The side of a square of the points' spread across their longest direction.
double WidthOf(const std::vector<Vector3d>& points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) {
    moments += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moments, Eigen::EigenvaluesOnly);
  return std::sqrt(12.0 * eigen.eigenvalues()[1]);
}

/// Gives each node of label -1 that of the nearest labelled one along the graph.
void Spread(const Graph& graph, std::vector<int>* labels) {
  std::deque<int> front;
  for (int i = 0; i < static_cast<int>(graph.size()); ++i) {
    if ((*labels)[i] >= 0) front.push_back(i);
  }
  while (!front.empty()) {
    const int i = front.front();
    front.pop_front();
    for (const int j : graph[i]) {
      if ((*labels)[j] >= 0) continue;
      (*labels)[j] = (*labels)[i];
      front.push_back(j);
    }
  }
}

}  // namespace

void SplitConfig::Validate() const {
  if (crease_deg <= 0.0 || crease_deg >= 180.0) {
    Throw<ConfigError>("crease_deg = {} must lie between 0 and 180", crease_deg);
  }
  if (window_m < 0.004 || window_m > 0.1) {
    Throw<ConfigError>("window_m = {} must lie in 0.004 to 0.1", window_m);
  }
  if (min_part_area_m2 < 0.0 || min_part_width_m < 0.0) {
    Throw<ConfigError>("min_part_area_m2 = {} and min_part_width_m = {} must not be negative",
                       min_part_area_m2, min_part_width_m);
  }
}

std::vector<int> SplitAtCreases(const std::vector<Vector3d>& points_C, const SplitConfig& config) {
  std::vector<int> one_part(points_C.size(), 0);
  if (points_C.empty()) return one_part;
  const double window = SurfaceWindow(points_C, config.window_m);
  const double cell = window / 2.0;
  const PointVoxels voxels(points_C, cell);
  Graph windows(voxels.size());
  for (int i = 0; i < voxels.size(); ++i) windows[i] = voxels.Neighbours(i, 2, window);
  const std::vector<SurfacePatch> patches = FitSurface(voxels, windows);

  const double sharpest = -config.crease_deg * std::numbers::pi / 180.0 / (2.0 * window);
  const auto is_crease = [&](int i) { return patches[i].min_curvature < sharpest; };
  Graph touching(voxels.size());
  Graph smooth(voxels.size());
  for (int i = 0; i < voxels.size(); ++i) {
    for (const int j : windows[i]) {
      if ((voxels.mean(j) - voxels.mean(i)).norm() > 1.8 * cell) continue;
      touching[i].push_back(j);
      if (!is_crease(i) && !is_crease(j)) smooth[i].push_back(j);
    }
  }
  std::vector<int> labels = ConnectedComponents(smooth);
  std::vector<std::vector<Vector3d>> parts;
  for (int i = 0; i < voxels.size(); ++i) {
    if (labels[i] >= static_cast<int>(parts.size())) parts.emplace_back();
    parts[labels[i]].push_back(voxels.mean(i));
  }
  std::vector<int> kept(parts.size(), -1);
  int count = 0;
  for (std::size_t part = 0; part < parts.size(); ++part) {
    const double area = cell * cell * static_cast<double>(parts[part].size());
    if (area < config.min_part_area_m2) continue;
    if (WidthOf(parts[part]) < config.min_part_width_m) continue;
    kept[part] = count++;
  }
  if (count < 2) return one_part;
  for (int& label : labels) label = kept[label];
  Spread(touching, &labels);
  Spread(windows, &labels);
  std::vector<int> result;
  for (const int voxel : voxels.voxel_of()) result.push_back(std::max(0, labels[voxel]));
  return result;
}

}  // namespace secondlook::perception
