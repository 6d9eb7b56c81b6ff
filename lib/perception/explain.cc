#include "lib/perception/explain.h"

#include <algorithm>
#include <cmath>

#include "lib/geometry/depth_rasteriser.h"

namespace secondlook::perception {
namespace {

constexpr int kReach = 3;             // [px]
constexpr float kTolerance = 0.015F;  // [m]

/// True when some pixel of the silhouette within kReach was rendered near the depth `z`.
bool Explains(const geometry::DepthRasteriser& rendered, int u, int v, float z) {
  const geometry::PixelRect& window = rendered.window();
  const int first_u = std::max(u - kReach, window.x);
  const int last_u = std::min(u + kReach, window.x + window.width - 1);
  const int first_v = std::max(v - kReach, window.y);
  const int last_v = std::min(v + kReach, window.y + window.height - 1);
  for (int y = first_v; y <= last_v; ++y) {
    for (int x = first_u; x <= last_u; ++x) {
      const float surface = rendered.depth()[(y - window.y) * window.width + (x - window.x)];
      if (std::abs(surface - z) < kTolerance) return true;  // false for NaN
    }
  }
  return false;
}

}  // namespace

world::Cluster MakeCluster(std::vector<int> pixels, const cv::Mat& depth,
                           const geometry::CameraModel& camera) {
  std::sort(pixels.begin(), pixels.end());
  world::Cluster cluster;
  for (const int pixel : pixels) {
    const int u = pixel % camera.width;
    const int v = pixel / camera.width;
    cluster.points_C.push_back(camera.Ray(u, v) * depth.at<float>(v, u));
    cluster.center_C += cluster.points_C.back();
    if (u < 2 || v < 2 || u >= camera.width - 2 || v >= camera.height - 2) {
      cluster.touches_border = true;
    }
  }
  if (!pixels.empty()) cluster.center_C /= static_cast<double>(pixels.size());
  cluster.pixels = std::move(pixels);
  return cluster;
}

world::Cluster TakeExplained(const geometry::Mesh& mesh, const Pose& X_CM, const cv::Mat& depth,
                             const geometry::CameraModel& camera, int min_left,
                             std::vector<world::Cluster>* clusters) {
  geometry::DepthRasteriser rendered;
  rendered.Render(mesh, X_CM, camera, ImageBounds(mesh, X_CM, camera, kReach));
  std::vector<int> taken;
  for (world::Cluster& cluster : *clusters) {
    std::vector<int> left;
    for (const int pixel : cluster.pixels) {
      const int u = pixel % camera.width;
      const int v = pixel / camera.width;
      (Explains(rendered, u, v, depth.at<float>(v, u)) ? taken : left).push_back(pixel);
    }
    if (left.size() == cluster.pixels.size()) continue;
    if (static_cast<int>(left.size()) < min_left) left.clear();
    cluster = MakeCluster(std::move(left), depth, camera);
  }
  std::erase_if(*clusters, [](const world::Cluster& cluster) { return cluster.pixels.empty(); });
  return MakeCluster(std::move(taken), depth, camera);
}

SurfaceAgreement CompareSurface(const geometry::Mesh& mesh, const Pose& X_CM, const cv::Mat& depth,
                                const geometry::CameraModel& camera) {
  geometry::DepthRasteriser rendered;
  rendered.Render(mesh, X_CM, camera, ImageBounds(mesh, X_CM, camera, 0));
  const geometry::PixelRect& window = rendered.window();
  SurfaceAgreement agreement;
  for (int y = 0; y < window.height; ++y) {
    for (int x = 0; x < window.width; ++x) {
      const float surface = rendered.depth()[y * window.width + x];
      const float behind = depth.at<float>(window.y + y, window.x + x) - surface;
      if (std::abs(behind) < kTolerance) ++agreement.matching;  // false for NaN, as is the next
      if (behind > 2.0F * kTolerance) ++agreement.see_through;
    }
  }
  return agreement;
}

}  // namespace secondlook::perception
