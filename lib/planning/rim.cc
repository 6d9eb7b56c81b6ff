#include "lib/planning/rim.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "lib/planning/model_analysis.h"

namespace secondlook::planning {
namespace {

/// So many rays tell a share within 0.1.
constexpr std::size_t kSamples = 32;

}  // namespace

double InnerShare(const PosedModel& model, const geometry::CameraModel& camera, const Pose& X_WC,
                  const std::vector<BoxRay>& rays, const std::vector<geometry::RayHit>& hits) {
  std::vector<std::size_t> hit;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].triangle >= 0) hit.push_back(i);
  }
  if (hit.empty()) return 0.0;
  const Eigen::Vector3d across_W = X_WC.linear().col(0) / camera.fx;
  const Eigen::Vector3d down_W = X_WC.linear().col(1) / camera.fy;
  const std::array<Eigen::Vector3d, 4> corners_W{across_W + down_W, across_W - down_W,
                                                 -across_W + down_W, -across_W - down_W};
  const std::size_t samples = std::min(hit.size(), kSamples);
  std::vector<BoxRay> around;
  for (std::size_t k = 0; k < samples; ++k) {
    const BoxRay& ray = rays[hit[k * hit.size() / samples]];
    for (const Eigen::Vector3d& corner_W : corners_W)
      around.push_back({ray.direction_W + corner_W});
  }
  const std::vector<geometry::RayHit> hits_around = CastAt(model, X_WC, around);
  std::size_t inner = 0;
  for (auto first = hits_around.begin(); first != hits_around.end(); first += corners_W.size()) {
    inner += std::all_of(first, first + corners_W.size(),
                         [](const geometry::RayHit& h) { return h.triangle >= 0; });
  }
  return static_cast<double>(inner) / static_cast<double>(samples);
}

}  // namespace secondlook::planning
