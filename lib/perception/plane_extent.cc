#include "lib/perception/plane_extent.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace secondlook::perception {

using Eigen::Vector3d;

std::array<Vector3d, 2> PlaneAxes(const Vector3d& normal) {
  const Vector3d u = normal.unitOrthogonal();
  return {u, normal.cross(u)};
}

cv::Point2f OnPlane(const std::array<Vector3d, 2>& axes, const Vector3d& p) {
  return {static_cast<float>(axes[0].dot(p)), static_cast<float>(axes[1].dot(p))};
}

std::vector<cv::Point2f> ConvexExtent(const std::vector<Vector3d>& points,
                                      const std::array<Vector3d, 2>& axes) {
  std::vector<cv::Point2f> flat;
  for (const Vector3d& p : points) flat.push_back(OnPlane(axes, p));
  std::vector<cv::Point2f> hull;
  cv::convexHull(flat, hull);
  return hull;
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

std::vector<Vector3d> ThinnedOnPlane(const std::vector<Vector3d>& points, const Vector3d& normal,
                                     double cell) {
  const auto axes = PlaneAxes(normal);
  std::set<std::pair<int, int>> taken;
  std::vector<Vector3d> thinned;
  for (const Vector3d& p : points) {
    const int u = static_cast<int>(std::floor(axes[0].dot(p) / cell));
    const int v = static_cast<int>(std::floor(axes[1].dot(p) / cell));
    if (taken.insert({u, v}).second) thinned.push_back(p);
  }
  return thinned;
}

}  // namespace secondlook::perception
