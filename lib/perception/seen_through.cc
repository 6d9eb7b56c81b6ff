#include "lib/perception/seen_through.h"

#include <cmath>

namespace secondlook::perception {
namespace {

constexpr double kTolerance = 0.015;  // [m]

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
    const double behind = depth.at<float>(v, u) - p_C.z();
    if (std::abs(behind) < kTolerance) ++agreement.matching;  // false for NaN, as is the next
    if (behind > 2.0 * kTolerance) ++agreement.see_through;
  }
  return agreement;
}

}  // namespace secondlook::perception
