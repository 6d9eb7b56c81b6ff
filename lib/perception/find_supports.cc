#include "lib/perception/find_supports.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>
#include <opencv2/imgproc.hpp>

#include "lib/common/rng.h"
#include "lib/perception/plane_extent.h"
#include "lib/perception/segment.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kRansacRounds = 400;
constexpr int kRansacPoints = 6000;
constexpr int kMaxPlanes = 5;
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

}  // namespace

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
        kPlaneCell * kPlaneCell *
        static_cast<double>(ThinnedOnPlane(patch, plane->normal, kPlaneCell).size());
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
        "{} (needs {}) and the largest covers {:.3f} m2 (needs {}, and a width of {} m); {} points "
        "within {} m were looked at",
        config.max_tilt_deg, most_points, config.min_plane_points, largest_area,
        config.min_plane_area_m2, config.min_plane_width_m, candidates.size(), config.max_range_m);
  }
  return found;
}

}  // namespace secondlook::perception
