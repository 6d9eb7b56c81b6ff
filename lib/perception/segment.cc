#include "lib/perception/segment.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"
#include "lib/perception/find_supports.h"
#include "lib/perception/hollow.h"
#include "lib/perception/plane_extent.h"
#include "lib/perception/point_voxels.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Where there is no depth some sources have NaN, others the origin.
bool HasDepth(const Vector3f& p) { return geometry::IsMeasured(p) && !p.isZero(); }

/// The measured points that can belong to a table or to what stands on it, as indices.
std::vector<int> Candidates(const geometry::PointImage& cloud, const Vector3d& up_C,
                            double max_range, double max_drop) {
  std::vector<int> indices;
  const Vector3f up = up_C.cast<float>();
  for (int i = 0; i < static_cast<int>(cloud.points_C.size()); ++i) {
    const Vector3f& p = cloud.points_C[i];
    if (!HasDepth(p) || p.norm() > max_range) continue;
    if (up.dot(p) < -max_drop) continue;
    indices.push_back(i);
  }
  return indices;
}

void RefuseWrongUnit(const geometry::PointImage& cloud) {
  std::vector<float> distances;
  for (const Vector3f& p : cloud.points_C) {
    if (HasDepth(p)) distances.push_back(p.norm());
  }
  if (distances.empty()) return;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  if (*middle > 50.0F) {
    Throw<InvalidArgument>(
        "the cloud's median distance is {:.1f} m, which no table's is; was it declared in the "
        "wrong unit (millimetres taken for metres)?",
        *middle);
  }
  if (*middle < 0.02F) {
    Throw<InvalidArgument>(
        "the cloud's median distance is {:.4f} m, nearer than any depth camera sees; was it "
        "declared in the wrong unit (metres taken for millimetres)?",
        *middle);
  }
}

/// Groups points whose distance is below `gap`, by voxels of half that size; labels count from 0.
std::vector<int> ClusterLabels(const std::vector<Vector3d>& points, double gap) {
  const PointVoxels voxels(points, gap / 2.0);
  std::vector<std::vector<int>> neighbours(voxels.size());
  for (int i = 0; i < voxels.size(); ++i) neighbours[i] = voxels.Neighbours(i, 2, gap);
  const std::vector<int> components = ConnectedComponents(neighbours);
  std::vector<int> labels;
  for (const int voxel : voxels.voxel_of()) labels.push_back(components[voxel]);
  return labels;
}

/// The points that stand over the convex extent of the support, or beyond it by no more than
/// `clearance`, as indices.
std::vector<int> PointsAbove(const geometry::PointImage& cloud, const std::vector<int>& candidates,
                             const Support& support, double clearance,
                             const SegmentConfig& config) {
  const world::SupportPlane& plane = support.plane;
  const auto axes = PlaneAxes(plane.normal_A);
  const std::vector<cv::Point2f> hull = ConvexExtent(support.patch, axes);
  std::vector<int> above;
  for (const int i : candidates) {
    const Vector3d p = cloud.points_C[i].cast<double>();
    const double height = plane.HeightOf(p);
    if (height < std::max(config.min_height_m, 3.0 * geometry::DepthSigma(p.z()))) continue;
    if (height > config.max_height_m) continue;
    if (cv::pointPolygonTest(hull, OnPlane(axes, p), true) < -clearance) continue;
    above.push_back(i);
  }
  return above;
}

bool OnBorder(const geometry::PointImage& cloud, int pixel) {
  const int u = pixel % cloud.width;
  const int v = pixel / cloud.width;
  return u < 2 || v < 2 || u >= cloud.width - 2 || v >= cloud.height - 2;
}

/// The points in groups by their labels, which count from 0.
std::vector<std::vector<int>> Grouped(const std::vector<int>& indices,
                                      const std::vector<int>& labels) {
  std::vector<std::vector<int>> groups;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (labels[i] >= static_cast<int>(groups.size())) groups.resize(labels[i] + 1);
    groups[labels[i]].push_back(indices[i]);
  }
  return groups;
}

std::vector<Vector3d> PointsOf(const geometry::PointImage& cloud, const std::vector<int>& indices) {
  std::vector<Vector3d> points;
  points.reserve(indices.size());
  for (const int i : indices) points.push_back(cloud.points_C[i].cast<double>());
  return points;
}

world::Cluster MakeCluster(const geometry::PointImage& cloud, const std::vector<int>& pixels) {
  world::Cluster cluster;
  cluster.pixels = pixels;
  cluster.points_C = PointsOf(cloud, pixels);
  for (const Vector3d& p : cluster.points_C) cluster.center_C += p;
  cluster.center_C /= static_cast<double>(pixels.size());
  cluster.touches_border =
      cloud.organised() &&
      std::any_of(pixels.begin(), pixels.end(), [&](int pixel) { return OnBorder(cloud, pixel); });
  return cluster;
}

/// The points of each thing: what is connected, cut where things touch, with the inside of what is
/// hollow joined to its outside.
std::vector<std::vector<int>> Things(const geometry::PointImage& cloud,
                                     const std::vector<int>& above,
                                     const world::SupportPlane& plane,
                                     const SegmentConfig& config) {
  const auto is_noise = [&](const std::vector<int>& pixels) {
    return static_cast<int>(pixels.size()) < config.min_cluster_points;
  };
  std::vector<std::vector<int>> connected =
      Grouped(above, ClusterLabels(PointsOf(cloud, above), config.cluster_gap_m));
  std::erase_if(connected, is_noise);
  if (!config.split_touching) return connected;

  std::vector<std::vector<int>> parts;
  std::vector<std::vector<Vector3d>> points;
  for (const std::vector<int>& pixels : connected) {
    const std::vector<int> labels = SplitAtCreases(PointsOf(cloud, pixels), config.split);
    for (std::vector<int>& part : Grouped(pixels, labels)) {
      if (is_noise(part)) continue;
      points.push_back(PointsOf(cloud, part));
      parts.push_back(std::move(part));
    }
  }
  const std::vector<int> outside = FindOutsides(points, plane, config.split.window_m);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (outside[i] == static_cast<int>(i)) continue;
    std::vector<int>& whole = parts[outside[i]];
    whole.insert(whole.end(), parts[i].begin(), parts[i].end());
    std::sort(whole.begin(), whole.end());
    parts[i].clear();
  }
  std::erase_if(parts, [](const std::vector<int>& part) { return part.empty(); });
  return parts;
}

/// A cluster and the support it stands on.
struct Standing {
  world::Cluster cluster;
  int support{};
};

/// What stands on each of `supports`, the largest first. From above, so that what stands on a box
/// is not of the box; what forms no cluster there is left to the support below.
std::vector<Standing> FindStanding(const geometry::PointImage& cloud, std::vector<int> candidates,
                                   const std::vector<Support>& supports,
                                   const SegmentConfig& config, std::size_t* above_first) {
  std::vector<int> order(supports.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return supports[a].height > supports[b].height; });
  std::vector<Standing> standing;
  for (const int k : order) {
    // Another thing may stand right beside a box, but over a table's edge things may reach.
    const double clearance = k == 0 ? config.edge_clearance_m : -config.edge_clearance_m / 2.0;
    const std::vector<int> above = PointsAbove(cloud, candidates, supports[k], clearance, config);
    if (k == 0) *above_first = above.size();
    std::vector<int> taken;
    for (const std::vector<int>& pixels : Things(cloud, above, supports[k].plane, config)) {
      standing.push_back({MakeCluster(cloud, pixels), k});
      taken.insert(taken.end(), pixels.begin(), pixels.end());
    }
    std::sort(taken.begin(), taken.end());
    std::erase_if(candidates,
                  [&](int i) { return std::binary_search(taken.begin(), taken.end(), i); });
  }
  std::stable_sort(standing.begin(), standing.end(), [](const Standing& a, const Standing& b) {
    return a.cluster.pixels.size() > b.cluster.pixels.size();
  });
  return standing;
}

}  // namespace

void SegmentConfig::Validate() const {
  const auto must_be_positive = [](const char* name, double value) {
    if (!(value > 0.0)) Throw<ConfigError>("{} = {} must be greater than 0", name, value);
  };
  if (!(max_tilt_deg > 0.0 && max_tilt_deg <= 90.0)) {
    Throw<ConfigError>("max_tilt_deg = {} must lie in 0 to 90, 0 excluded", max_tilt_deg);
  }
  must_be_positive("max_range_m", max_range_m);
  must_be_positive("min_plane_points", min_plane_points);
  must_be_positive("cluster_gap_m", cluster_gap_m);
  must_be_positive("min_cluster_points", min_cluster_points);
  split.Validate();
  if (min_plane_area_m2 < 0.0 || min_plane_width_m < 0.0 || edge_clearance_m < 0.0) {
    Throw<ConfigError>(
        "min_plane_area_m2 = {}, min_plane_width_m = {} and edge_clearance_m = {} must not be "
        "negative",
        min_plane_area_m2, min_plane_width_m, edge_clearance_m);
  }
  if (!(min_height_m >= 0.0 && min_height_m < max_height_m)) {
    Throw<ConfigError>("min_height_m = {} must not be negative, and max_height_m = {} above it",
                       min_height_m, max_height_m);
  }
}

void PutFirst(const world::SupportPlane& known_W, const Pose& X_WC, Segmentation* segmentation) {
  constexpr double kTolerance = 0.03;  // [m]
  const auto off = [&](const world::SupportPlane& plane_C) {
    const world::SupportPlane plane_W = world::Transform(X_WC, plane_C);
    const Vector3d middle_W = (plane_W.corners_A[0] + plane_W.corners_A[2]) / 2.0;
    return std::abs(known_W.HeightOf(middle_W));
  };
  if (!segmentation->plane_C || off(*segmentation->plane_C) < kTolerance) return;
  for (std::size_t k = 0; k < segmentation->further.size(); ++k) {
    FurtherSupport& other = segmentation->further[k];
    if (off(other.plane_C) >= kTolerance) continue;
    std::swap(*segmentation->plane_C, other.plane_C);
    std::swap(segmentation->plane_points_C, other.points_C);
    const auto second = static_cast<int>(k) + 1;
    for (int& support : segmentation->stands_on) {
      if (support == 0 || support == second) support = second - support;
    }
    return;
  }
}

Segmentation Segment(const geometry::PointImage& cloud, const Vector3d& up_C,
                     const SegmentConfig& config, double max_drop) {
  if (!up_C.allFinite() || up_C.norm() < 1e-9) {
    Throw<InvalidArgument>("up = ({}, {}, {}) must be a direction", up_C.x(), up_C.y(), up_C.z());
  }
  RefuseWrongUnit(cloud);
  const Vector3d up = up_C.normalized();
  const std::vector<int> candidates = Candidates(cloud, up, config.max_range_m, max_drop);
  PlaneSearch search = FindSupports(cloud, candidates, up, config, std::isfinite(max_drop));
  Segmentation result;
  result.reason = search.reason;
  if (search.supports.empty()) return result;

  std::size_t above = 0;
  for (Standing& thing : FindStanding(cloud, candidates, search.supports, config, &above)) {
    result.clusters.push_back(std::move(thing.cluster));
    result.stands_on.push_back(thing.support);
  }
  for (const Support& support : search.supports) {
    std::vector<Vector3d> points_C =
        ThinnedOnPlane(support.patch, support.plane.normal_A, kPlaneCell);
    if (result.plane_C) {
      result.further.push_back({support.plane, std::move(points_C)});
    } else {
      result.plane_C = support.plane;
      result.plane_points_C = std::move(points_C);
    }
  }
  if (result.clusters.empty()) {
    result.reason = fmt::format(
        "nothing stands on the support plane: {} points above it form no "
        "cluster of {} points",
        above, config.min_cluster_points);
  }
  return result;
}

}  // namespace secondlook::perception
