#include "lib/perception/own_body.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lib/common/error.h"

namespace secondlook::perception {
namespace {

/// The pixels that may see a ball: all of them when the camera is in it or beside it.
cv::Rect PixelsOf(const Eigen::Vector3d& p_CS, double radius, const geometry::CameraModel& camera) {
  const cv::Rect all(0, 0, camera.width, camera.height);
  const double nearest = p_CS.z() - radius;
  if (p_CS.z() + radius <= 0.0) return {};
  if (nearest <= 0.01) return all;
  // The box around the ball: its corners nearest to the camera appear farthest out.
  const auto range = [&](double center, double focal, double middle) {
    const double low = center - radius;
    const double high = center + radius;
    const double far = p_CS.z() + radius;
    return std::pair{middle + focal * low / (low < 0.0 ? nearest : far),
                     middle + focal * high / (high > 0.0 ? nearest : far)};
  };
  const auto [left, right] = range(p_CS.x(), camera.fx, camera.cx);
  const auto [top, bottom] = range(p_CS.y(), camera.fy, camera.cy);
  const auto pixel = [](double value, int size) {
    return static_cast<int>(std::clamp(value, -1.0, static_cast<double>(size)));
  };
  const cv::Point begin(pixel(std::floor(left), camera.width),
                        pixel(std::floor(top), camera.height));
  const cv::Point end(pixel(std::ceil(right) + 1.0, camera.width),
                      pixel(std::ceil(bottom) + 1.0, camera.height));
  return all & cv::Rect(begin, end);
}

}  // namespace

cv::Mat WithoutOwnBody(const cv::Mat& depth, const geometry::CameraModel& camera,
                       const std::vector<geometry::PlacedShape>& body_C, double margin) {
  if (!(margin >= 0.0) || !std::isfinite(margin)) {
    Throw<InvalidArgument>("own body: a margin of {} m", margin);
  }
  if (depth.empty()) return depth;
  if (depth.type() != CV_32FC1 || depth.cols != camera.width || depth.rows != camera.height) {
    Throw<InvalidArgument>("own body: a depth image of {} x {} pixels for a camera of {} x {}",
                           depth.cols, depth.rows, camera.width, camera.height);
  }
  cv::Mat rest = depth.clone();
  for (const geometry::PlacedShape& part : body_C) {
    const double radius = geometry::BoundingRadius(part.shape) + margin;
    const Eigen::Vector3d p_CS = part.X_AS.translation();
    const Pose X_SC = part.X_AS.inverse();
    const cv::Rect pixels = PixelsOf(p_CS, radius, camera);
    for (int v = pixels.y; v < pixels.y + pixels.height; ++v) {
      auto* row = rest.ptr<float>(v);
      for (int u = pixels.x; u < pixels.x + pixels.width; ++u) {
        const double z = row[u];
        if (!(std::abs(z - p_CS.z()) <= radius)) continue;  // true for NaN
        const Eigen::Vector3d p_CQ((u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z,
                                   z);
        if (geometry::Distance(part.shape, X_SC * p_CQ) > margin) continue;
        row[u] = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  return rest;
}

}  // namespace secondlook::perception
