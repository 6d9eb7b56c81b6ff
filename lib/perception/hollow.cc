#include "lib/perception/hollow.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "lib/perception/point_voxels.h"
#include "lib/perception/surface.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;

constexpr double kWidestRadius = 0.25;  // Of a wall that counts as bent [m].
constexpr double kRimGap = 0.04;        // Rims return no depth; the two sides are so far apart [m].
constexpr double kRimTolerance = 0.02;  // How level a rim is [m].

struct Part {
  std::vector<Vector3d> points_C;  ///< One per voxel.
  double curvature{};              ///< Median of the mean curvature [1/m].
  double top{};                    ///< Height of the highest, but for a few stray points [m].
};

template <class T>
T Quantile(std::vector<T> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Part Describe(const std::vector<Vector3d>& points_C, const world::SupportPlane& plane_C,
              double least_window) {
  const double window = SurfaceWindow(points_C, least_window);
  const PointVoxels voxels(points_C, window / 2.0);
  std::vector<std::vector<int>> windows(voxels.size());
  Part part;
  std::vector<double> heights;
  for (int i = 0; i < voxels.size(); ++i) {
    windows[i] = voxels.Neighbours(i, 2, window);
    part.points_C.push_back(voxels.mean(i));
    heights.push_back(plane_C.HeightOf(voxels.mean(i)));
  }
  std::vector<double> curvatures;
  for (const SurfacePatch& patch : FitSurface(voxels, windows)) {
    curvatures.push_back(patch.mean_curvature());
  }
  part.curvature = Quantile(curvatures, 0.5);
  part.top = Quantile(heights, 0.98);
  return part;
}

double Distance(const Part& a, const Part& b) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vector3d& p : a.points_C) {
    for (const Vector3d& q : b.points_C) nearest = std::min(nearest, (p - q).squaredNorm());
  }
  return std::sqrt(nearest);
}

}  // namespace

std::vector<int> FindOutsides(const std::vector<std::vector<Vector3d>>& parts_C,
                              const world::SupportPlane& plane_C, double window) {
  std::vector<Part> parts;
  for (const auto& points_C : parts_C) parts.push_back(Describe(points_C, plane_C, window));
  // The mean curvature of a bent wall is half that across it.
  const auto is_inside = [](const Part& part) { return part.curvature < -0.5 / kWidestRadius; };
  std::vector<int> outside(parts.size());
  std::iota(outside.begin(), outside.end(), 0);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!is_inside(parts[i])) continue;
    double nearest = kRimGap;
    for (std::size_t j = 0; j < parts.size(); ++j) {
      if (j == i || is_inside(parts[j])) continue;
      if (std::abs(parts[j].top - parts[i].top) > kRimTolerance) continue;
      const double distance = Distance(parts[i], parts[j]);
      if (distance >= nearest) continue;
      nearest = distance;
      outside[i] = static_cast<int>(j);
    }
  }
  return outside;
}

}  // namespace secondlook::perception
