#include "lib/perception/segment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include <Eigen/Eigenvalues>
#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/perception/hollow.h"
#include "lib/perception/point_voxels.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kRansacRounds = 400;
constexpr int kRansacPoints = 6000;
constexpr int kMaxPlanes = 5;
constexpr double kThinning = 0.02;               // [m]
constexpr double kMaxTiltBetweenPlanes = 0.175;  // [rad]
constexpr double kMaxTiltOfThings = 0.035;       // [rad]

struct Plane {
  Vector3d normal;
  double offset;
};

/// How far from a plane a point at depth z may lie and still belong to it.
double PlaneTolerance(double z) { return std::max(0.006, 2.5 * geometry::DepthSigma(z)); }

bool LiesOn(const Plane& plane, const Vector3d& p) {
  return std::abs(plane.normal.dot(p) - plane.offset) < PlaneTolerance(p.z());
}

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

/// Least squares over the points near the plane; the normal keeps to the side of `up`.
template <class Point>
Plane Refit(const std::vector<Point>& points, const Plane& plane, const Vector3d& up) {
  Vector3d mean = Vector3d::Zero();
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  double count = 0.0;
  for (const Point& point : points) {
    const Vector3d p = point.template cast<double>();
    if (!LiesOn(plane, p)) continue;
    mean += p;
    moments += p * p.transpose();
    count += 1.0;
  }
  if (count < 3.0) return plane;
  mean /= count;
  const Eigen::Matrix3d covariance = moments / count - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
  Vector3d normal = eigen.eigenvectors().col(0);
  if (normal.dot(up) < 0.0) normal = -normal;
  return {normal, normal.dot(mean)};
}

/// A random point between 5 and 40 cm from `p`: one that may well lie on the same table, where most
/// of what the camera sees is floor and wall. After some vain tries, any point.
const Vector3f& PointNear(const std::vector<Vector3f>& points, const Vector3f& p, Rng* rng) {
  constexpr int kTries = 60;
  for (int i = 0; i < kTries; ++i) {
    const Vector3f& other = points[rng->Index(static_cast<int>(points.size()))];
    const float distance = (other - p).norm();
    if (distance > 0.05F && distance < 0.4F) return other;
  }
  return p;
}

/// The plane with the most points whose normal lies within `max_tilt` [rad] of `up`.
std::optional<Plane> Ransac(const std::vector<Vector3f>& points, const Vector3d& up,
                            double max_tilt, Rng* rng) {
  const double min_cosine = std::cos(max_tilt);
  const int count = static_cast<int>(points.size());
  std::optional<Plane> best;
  int best_inliers = 0;
  for (int round = 0; round < kRansacRounds; ++round) {
    const Vector3f& first = points[rng->Index(count)];
    const Vector3d a = first.cast<double>();
    const Vector3d b = PointNear(points, first, rng).cast<double>();
    const Vector3d c = PointNear(points, first, rng).cast<double>();
    Vector3d normal = (b - a).cross(c - a);
    if (normal.norm() < 1e-5) continue;  // nearly on one line
    normal.normalize();
    if (normal.dot(up) < 0.0) normal = -normal;
    if (normal.dot(up) < min_cosine) continue;
    const Plane plane{normal, normal.dot(a)};
    const int inliers =
        static_cast<int>(std::count_if(points.begin(), points.end(), [&](const Vector3f& p) {
          return LiesOn(plane, p.cast<double>());
        }));
    if (inliers > best_inliers) {
      best_inliers = inliers;
      best = plane;
    }
  }
  return best;
}

/// Two axes that span the plane with this normal.
std::array<Vector3d, 2> PlaneAxes(const Vector3d& normal) {
  const Vector3d u = normal.unitOrthogonal();
  return {u, normal.cross(u)};
}

cv::Point2f OnPlane(const std::array<Vector3d, 2>& axes, const Vector3d& p) {
  return {static_cast<float>(axes[0].dot(p)), static_cast<float>(axes[1].dot(p))};
}

/// The largest patch of the plane: points more than 4 cm apart do not connect.
std::vector<Vector3d> LargestPatch(const std::vector<Vector3d>& points, const Vector3d& normal) {
  constexpr float kCell = 0.02F;
  const auto axes = PlaneAxes(normal);
  std::vector<cv::Point2f> flat;
  for (const Vector3d& p : points) flat.push_back(OnPlane(axes, p));
  const cv::Rect2f bounds = cv::boundingRect(flat);
  cv::Mat cells = cv::Mat::zeros(static_cast<int>(bounds.height / kCell) + 2,
                                 static_cast<int>(bounds.width / kCell) + 2, CV_8U);
  const auto cell_of = [&](const cv::Point2f& p) {
    return cv::Point(static_cast<int>((p.x - bounds.x) / kCell),
                     static_cast<int>((p.y - bounds.y) / kCell));
  };
  for (const cv::Point2f& p : flat) cells.at<std::uint8_t>(cell_of(p)) = 255;
  cv::dilate(cells, cells, cv::Mat::ones(3, 3, CV_8U));
  cv::Mat labels;
  const int label_count = cv::connectedComponents(cells, labels, 8, CV_32S);
  std::vector<int> sizes(label_count, 0);
  for (const cv::Point2f& p : flat) ++sizes[labels.at<int>(cell_of(p))];
  const int largest =
      static_cast<int>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
  std::vector<Vector3d> patch;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (labels.at<int>(cell_of(flat[i])) == largest) patch.push_back(points[i]);
  }
  return patch;
}

/// The convex extent of points on a plane, in the plane's axes.
std::vector<cv::Point2f> ConvexExtent(const std::vector<Vector3d>& points,
                                      const std::array<Vector3d, 2>& axes) {
  std::vector<cv::Point2f> flat;
  for (const Vector3d& p : points) flat.push_back(OnPlane(axes, p));
  std::vector<cv::Point2f> hull;
  cv::convexHull(flat, hull);
  return hull;
}

/// One point for each cell of kThinning on the plane.
std::vector<Vector3d> Thinned(const std::vector<Vector3d>& points, const Vector3d& normal) {
  const auto axes = PlaneAxes(normal);
  std::set<std::pair<int, int>> taken;
  std::vector<Vector3d> thinned;
  for (const Vector3d& p : points) {
    const int u = static_cast<int>(std::floor(axes[0].dot(p) / kThinning));
    const int v = static_cast<int>(std::floor(axes[1].dot(p) / kThinning));
    if (taken.insert({u, v}).second) thinned.push_back(p);
  }
  return thinned;
}

/// A level plane that is large enough to stand on.
struct Support {
  world::SupportPlane plane;
  std::vector<Vector3d> patch;  ///< The points it was fitted to.
  double height{};              ///< Of the patch, along the normal of the first that was found.
  double extent{};              ///< Of its convex extent [m2].
};

struct PlaneSearch {
  std::vector<Support> supports;  ///< The one that counts first, the others by falling extent.
  std::string reason;
};

/// Puts the support that counts first: the highest, or the largest where the floor is out of the
/// question. Where it is not, the lowest of several may be the floor, and goes.
void Rank(bool floor_is_out, std::vector<Support>* supports) {
  std::stable_sort(supports->begin(), supports->end(),
                   [](const Support& a, const Support& b) { return a.extent > b.extent; });
  if (floor_is_out || supports->size() < 2) return;
  const auto lower = [](const Support& a, const Support& b) { return a.height < b.height; };
  supports->erase(std::min_element(supports->begin(), supports->end(), lower));
  const auto highest = std::max_element(supports->begin(), supports->end(), lower);
  std::rotate(supports->begin(), highest, highest + 1);
}

/// The planes with a normal near `up` that are large enough.
PlaneSearch FindSupports(const geometry::PointImage& cloud, const std::vector<int>& candidates,
                         const Vector3d& up, const SegmentConfig& config, bool floor_is_out) {
  Rng rng(1);  // chance in finding a plane, not in the result: any seed serves
  const std::size_t stride = std::max<std::size_t>(1, candidates.size() / kRansacPoints);
  std::vector<Vector3f> sample;
  for (std::size_t i = 0; i < candidates.size(); i += stride) {
    sample.push_back(cloud.points_C[candidates[i]]);
  }
  std::vector<int> left = candidates;
  std::optional<Plane> ground;  // the first: it has the most points
  Vector3d level = up;
  double max_tilt = config.max_tilt_deg * std::numbers::pi / 180.0;
  PlaneSearch found;
  int most_points = 0;
  double largest_area = 0.0;
  for (int round = 0; round < kMaxPlanes && sample.size() >= 10; ++round) {
    std::optional<Plane> plane = Ransac(sample, level, max_tilt, &rng);
    if (!plane) break;
    for (int i = 0; i < 3; ++i) plane = Refit(sample, *plane, up);
    std::vector<Vector3d> inliers;
    for (const int i : left) {
      const Vector3d p = cloud.points_C[i].cast<double>();
      if (LiesOn(*plane, p)) inliers.push_back(p);
    }
    // The best fit to a strip of wall is the wall.
    const bool is_level = plane->normal.dot(level) >= std::cos(max_tilt);
    if (is_level) most_points = std::max(most_points, static_cast<int>(inliers.size()));
    std::vector<Vector3d> patch;
    if (is_level && static_cast<int>(inliers.size()) >= config.min_plane_points) {
      patch = LargestPatch(inliers, plane->normal);
      // By itself: what else the plane cuts through has tilted it.
      plane = Refit(patch, *plane, up);
    }
    // A point belongs to the first plane only: the edge of a table is no second, tilted table.
    std::erase_if(sample, [&](const Vector3f& p) { return LiesOn(*plane, p.cast<double>()); });
    std::erase_if(left, [&](int i) { return LiesOn(*plane, cloud.points_C[i].cast<double>()); });
    if (patch.empty()) continue;
    // Not the convex extent: a plane through the flanks of many things has that, but no surface.
    const double area =
        kThinning * kThinning * static_cast<double>(Thinned(patch, plane->normal).size());
    largest_area = std::max(largest_area, area);
    const auto corners = FitRectangle(patch, plane->normal, plane->offset);
    const double width =
        std::min((corners[1] - corners[0]).norm(), (corners[2] - corners[1]).norm());
    if (area < config.min_plane_area_m2 || width < config.min_plane_width_m) continue;
    if (!ground) {
      ground = plane;
      level = plane->normal;
      max_tilt = std::min(max_tilt, kMaxTiltBetweenPlanes);
    }
    double height = 0.0;
    for (const Vector3d& p : patch) height += level.dot(p) / static_cast<double>(patch.size());
    // As low over the ground as a thing is high, what leans is the top of a thing.
    const bool over_things = height - ground->offset > config.max_height_m;
    const double tilt = std::acos(std::min(1.0, plane->normal.dot(level)));
    if (!over_things && tilt > kMaxTiltOfThings) continue;
    // The extent, not what was seen of it: what is far is seen in fewer points.
    const double extent = cv::contourArea(ConvexExtent(patch, PlaneAxes(plane->normal)));
    const auto count = static_cast<int>(patch.size());
    found.supports.push_back(
        {{plane->normal, plane->offset, corners, count}, std::move(patch), height, extent});
  }
  Rank(floor_is_out, &found.supports);
  if (found.supports.empty()) {
    found.reason = fmt::format(
        "no support plane: of the planes within {} deg of level, the one with the most points has "
        "{} "
        "(needs {}) and the largest covers {:.3f} m2 (needs {}, and a width of {} m); {} points "
        "within {} "
        "m were looked at",
        config.max_tilt_deg, most_points, config.min_plane_points, largest_area,
        config.min_plane_area_m2, config.min_plane_width_m, candidates.size(), config.max_range_m);
  }
  return found;
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

std::array<Vector3d, 4> FitRectangle(const std::vector<Vector3d>& points_C,
                                     const Vector3d& normal_C, double offset) {
  const auto axes = PlaneAxes(normal_C);
  std::vector<cv::Point2f> flat;
  for (const Vector3d& p : points_C) flat.push_back(OnPlane(axes, p));
  std::array<Vector3d, 4> corners;
  if (flat.empty()) {
    corners.fill(normal_C * offset);
    return corners;
  }
  std::array<cv::Point2f, 4> flat_corners;
  cv::minAreaRect(flat).points(flat_corners.data());
  for (int i = 0; i < 4; ++i) {
    corners[i] = axes[0] * flat_corners[i].x + axes[1] * flat_corners[i].y + normal_C * offset;
  }
  const bool clockwise =
      (corners[1] - corners[0]).cross(corners[2] - corners[1]).dot(normal_C) < 0.0;
  if (clockwise) std::reverse(corners.begin(), corners.end());
  return corners;
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
    std::vector<Vector3d> points_C = Thinned(support.patch, support.plane.normal_A);
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
