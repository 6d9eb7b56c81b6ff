#include "lib/perception/cuts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Core>
#include <opencv2/imgproc.hpp>

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;

constexpr double kLeastShare = 1.0 / 6.0;
constexpr double kNearlySquare = 1.3;    // longer to other side: it may be cut across either
constexpr double kLongRow = 2.0;         // longer to other side: it may be three in a row
constexpr double kStep = 0.005;          // between the places of a cut that are looked at [m]
constexpr double kSide = 0.01;           // how far from a cut its sides are looked at [m]…
constexpr double kEdge = 0.002;          // …but for pixels that mix both [m]…
constexpr double kCell = 0.01;           // …in cells of so much along it [m]
constexpr int kLeastCellPixels = 5;      // on either side
constexpr int kLeastCells = 4;           // along a cut
constexpr double kLeastContrast = 40.0;  // between the colours on either side, of 255
constexpr double kMostAlong = 0.85;      // of a cut's cells have that contrast

/// Two axes of the plane, along the longer and the other side of the smallest rectangle around what
/// stands on it.
std::array<Vector3d, 2> SidesOf(const std::vector<Vector3d>& points_C, const Vector3d& normal_C) {
  const Vector3d u = normal_C.unitOrthogonal();
  const Vector3d v = normal_C.cross(u);
  std::vector<cv::Point2f> flat;
  for (const Vector3d& p : points_C) {
    flat.emplace_back(static_cast<float>(u.dot(p)), static_cast<float>(v.dot(p)));
  }
  std::array<cv::Point2f, 4> corners;
  cv::minAreaRect(flat).points(corners.data());
  std::array<Vector3d, 2> sides;
  for (int i = 0; i < 2; ++i) {
    const cv::Point2f side = corners[i + 1] - corners[i];
    sides[i] = u * side.x + v * side.y;
  }
  if (sides[0].norm() < sides[1].norm()) std::swap(sides[0], sides[1]);
  for (Vector3d& side : sides) side.normalize();
  return sides;
}

/// The colours on one side of a cut, in one cell along it.
struct Side {
  Vector3d sum{Vector3d::Zero()};
  int count{};
};

/// What the colours on the two sides of a plane through a cluster are like.
struct Contrast {
  double share{};  ///< Of the cells along the plane, where they differ much.
  double mean{};   ///< Of their difference.
};

/// Across the plane at `at` along the first of `axes`; cells are counted along the other two.
Contrast ContrastAt(const world::Cluster& cluster, const View& view,
                    const std::array<Vector3d, 3>& axes, double at) {
  std::map<std::pair<int, int>, std::array<Side, 2>> cells;
  for (std::size_t i = 0; i < cluster.pixels.size(); ++i) {
    const Vector3d& p = cluster.points_C[i];
    const double off = axes[0].dot(p) - at;
    if (std::abs(off) > kSide || std::abs(off) < kEdge) continue;
    const std::pair cell(static_cast<int>(std::floor(axes[1].dot(p) / kCell)),
                         static_cast<int>(std::floor(axes[2].dot(p) / kCell)));
    Side& side = cells[cell][off < 0.0 ? 0 : 1];
    const cv::Vec3b& rgb = view.color.at<cv::Vec3b>(cluster.pixels[i] / view.camera.width,
                                                    cluster.pixels[i] % view.camera.width);
    side.sum += Vector3d(rgb[0], rgb[1], rgb[2]);
    ++side.count;
  }
  Contrast contrast;
  int compared = 0;
  for (const auto& [cell, sides] : cells) {
    if (std::min(sides[0].count, sides[1].count) < kLeastCellPixels) continue;
    ++compared;
    const double difference =
        (sides[0].sum / sides[0].count - sides[1].sum / sides[1].count).cwiseAbs().maxCoeff();
    contrast.mean += difference;
    if (difference > kLeastContrast) contrast.share += 1.0;
  }
  if (compared < kLeastCells) return {};
  return {contrast.share / compared, contrast.mean / compared};
}

/// The ends of the cluster along `direction`, but for a hundredth of the points at either.
std::array<double, 2> EndsAlong(const world::Cluster& cluster, const Vector3d& direction) {
  std::vector<double> along;
  for (const Vector3d& p : cluster.points_C) along.push_back(direction.dot(p));
  std::sort(along.begin(), along.end());
  return {along[along.size() / 100], along[along.size() - 1 - along.size() / 100]};
}

double LengthAlong(const world::Cluster& cluster, const Vector3d& direction) {
  const auto [low, high] = EndsAlong(cluster, direction);
  return high - low;
}

Cut CutAt(const world::Cluster& cluster, const Vector3d& direction, double at) {
  Cut cut;
  for (std::size_t i = 0; i < cluster.pixels.size(); ++i) {
    cut[direction.dot(cluster.points_C[i]) < at ? 0 : 1].push_back(cluster.pixels[i]);
  }
  return cut;
}

/// Takes out cuts with a part of less than `share` of the cluster.
void DropSlivers(const world::Cluster& cluster, double share, std::vector<Cut>* cuts) {
  const double least = share * static_cast<double>(cluster.pixels.size());
  std::erase_if(*cuts, [&](const Cut& cut) {
    return static_cast<double>(std::min(cut[0].size(), cut[1].size())) < std::max(1.0, least);
  });
}

}  // namespace

std::vector<Cut> CutsByShape(const world::Cluster& cluster, const world::SupportPlane& plane_C) {
  if (cluster.points_C.size() < 3) return {};
  const auto [longer, other] = SidesOf(cluster.points_C, plane_C.normal_A);
  const double length = LengthAlong(cluster, longer);
  const double width = LengthAlong(cluster, other);
  const double height = LengthAlong(cluster, plane_C.normal_A);
  std::vector<Cut> cuts;
  const auto add = [&](const Vector3d& direction, double share) {
    const auto [low, high] = EndsAlong(cluster, direction);
    cuts.push_back(CutAt(cluster, direction, low + share * (high - low)));
  };
  if (height > length) {
    add(plane_C.normal_A, 1.0 / 2.0);
  } else {
    add(longer, 1.0 / 2.0);
    if (length < kNearlySquare * width) add(other, 1.0 / 2.0);
    if (length > kLongRow * width) add(longer, 1.0 / 3.0);
  }
  DropSlivers(cluster, kLeastShare, &cuts);
  return cuts;
}

std::vector<Cut> CutsByColor(const world::Cluster& cluster, const View& view) {
  if (view.color.empty() || cluster.points_C.size() < 3) return {};
  const Vector3d& up = view.plane_C.normal_A;
  const auto [longer, other] = SidesOf(cluster.points_C, up);
  std::vector<Cut> cuts;
  for (const std::array<Vector3d, 3>& axes :
       {std::array{longer, other, up}, std::array{other, longer, up},
        std::array{up, longer, other}}) {
    const auto [low, high] = EndsAlong(cluster, axes[0]);
    double strongest = 0.0;
    double best = 0.0;
    for (double at = low + kSide; at < high - kSide; at += kStep) {
      const Contrast contrast = ContrastAt(cluster, view, axes, at);
      if (contrast.share < kMostAlong || contrast.mean <= strongest) continue;
      strongest = contrast.mean;
      best = at;
    }
    if (strongest > 0.0) cuts.push_back(CutAt(cluster, axes[0], best));
  }
  DropSlivers(cluster, 0.0, &cuts);
  return cuts;
}

}  // namespace secondlook::perception
