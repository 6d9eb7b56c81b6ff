#include "lib/perception/seen_through.h"

#include <algorithm>
#include <cmath>

namespace secondlook::perception {
namespace {

constexpr double kTolerance = 0.015;  // [m]
constexpr double kReach = 0.010;      // [m] that a view may be off, and thin things narrow

enum class Finding { kNothing, kMatching, kSeenThrough };

/// What the pixels around (u, v) say of a surface at depth `z`.
Finding Look(const cv::Mat& depth, int u, int v, int reach, double z) {
  bool silent = false;
  for (int y = std::max(0, v - reach); y <= std::min(depth.rows - 1, v + reach); ++y) {
    for (int x = std::max(0, u - reach); x <= std::min(depth.cols - 1, u + reach); ++x) {
      const double behind = depth.at<float>(y, x) - z;
      if (std::abs(behind) < kTolerance) return Finding::kMatching;  // false for NaN
      silent = silent || !(behind > 2.0 * kTolerance);
    }
  }
  return silent ? Finding::kNothing : Finding::kSeenThrough;
}

}  // namespace

SurfaceAgreement ComparePoints(const std::vector<Eigen::Vector3d>& points_W, const Pose& X_WC,
                               const cv::Mat& depth, const geometry::CameraModel& camera) {
  const Pose X_CW = X_WC.inverse();
  SurfaceAgreement agreement;
  for (const Eigen::Vector3d& p_W : points_W) {
    const Eigen::Vector3d p_C = X_CW * p_W;
    const auto pixel = camera.Project(p_C);
    if (!pixel) continue;
    const auto u = static_cast<int>(std::lround(pixel->x()));
    const auto v = static_cast<int>(std::lround(pixel->y()));
    const auto reach = static_cast<int>(std::ceil(kReach * camera.fx / p_C.z()));
    const Finding finding = Look(depth, u, v, reach, p_C.z());
    if (finding == Finding::kMatching) ++agreement.matching;
    if (finding == Finding::kSeenThrough) ++agreement.see_through;
  }
  return agreement;
}

}  // namespace secondlook::perception
