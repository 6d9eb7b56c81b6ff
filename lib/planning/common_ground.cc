#include "lib/planning/common_ground.h"

#include <algorithm>
#include <cmath>

namespace secondlook::planning {
namespace {

constexpr double kMaxUp = 0.5;       // of the normal of what is upright
constexpr double kMinFacing = 0.17;  // cosine of 80 degrees: beyond, depth cameras see nothing
constexpr double kReferenceCell_m = 0.005;  // perception::ReferenceCloud's

}  // namespace

CommonGround::CommonGround(const std::vector<perception::SurfacePoint>& reference_W,
                           const perception::RegisterConfig& config)
    : min_pairs_(config.min_pairs) {
  for (const perception::SurfacePoint& point : reference_W) {
    if (std::abs(point.normal_A.z()) < kMaxUp) upright_W_.push_back(point);
  }
  // A view is thinned to wider cells than the map.
  pairs_a_point_ = std::min(1.0, std::pow(kReferenceCell_m / config.object_spacing_m, 2));
}

double CommonGround::Pairs(const Pose& X_WC, const hal::CameraInfo& camera) const {
  const Pose X_CW = X_WC.inverse();
  const auto shared = [&](const perception::SurfacePoint& point) {
    const Eigen::Vector3d to_camera = X_WC.translation() - point.p_AP;
    if (point.normal_A.dot(to_camera) < kMinFacing * to_camera.norm()) return false;
    const Eigen::Vector3d p_CP = X_CW * point.p_AP;
    if (camera.has_depth && !(p_CP.z() > camera.min_depth && p_CP.z() < camera.max_depth)) {
      return false;
    }
    return camera.model.Project(p_CP).has_value();
  };
  double pairs = 0.0;
  for (const perception::SurfacePoint& point : upright_W_) {
    if (pairs >= min_pairs_) break;
    if (shared(point)) pairs += pairs_a_point_;
  }
  return pairs;
}

double CommonGround::ChanceOf(double pairs) const {
  return min_pairs_ > 0 ? std::min(1.0, pairs / min_pairs_) : 1.0;
}

}  // namespace secondlook::planning
