#include "apps/support_planes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lib/geometry/sampling.h"
#include "lib/perception/plane_extent.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

/// Planes that differ less in height, and reach so near to one another, are one.
constexpr double kSameLevel_m = 0.03;
constexpr double kPlaneReach_m = 0.1;
constexpr double kPointSpacing_m = 0.02;

/// Lets `plane_W` reach as far as its points, which are `points_W` and, from X_WC, `more_C`.
void Extend(const std::vector<Vector3d>& more_C, const Pose& X_WC, std::vector<Vector3d>* points_W,
            world::SupportPlane* plane_W) {
  *points_W = geometry::Thinned(std::move(*points_W), Transform(X_WC, more_C), kPointSpacing_m);
  plane_W->corners_A = perception::FitRectangle(*points_W, plane_W->normal_A, plane_W->offset);
  plane_W->inliers = static_cast<int>(points_W->size());
}

}  // namespace

void SupportPlanes::Grow(const perception::Segmentation& seen, const Pose& X_WC,
                         world::SceneBelief* belief) {
  if (!belief->plane_W) belief->plane_W = world::Transform(X_WC, *seen.plane_C);
  Extend(seen.plane_points_C, X_WC, &points_W_, &*belief->plane_W);
  for (const perception::FurtherSupport& further : seen.further) {
    GrowFurther(further, X_WC, &belief->further_W);
  }
}

/// Each grows the one that it continues, or is new.
void SupportPlanes::GrowFurther(const perception::FurtherSupport& seen, const Pose& X_WC,
                                std::vector<world::SupportPlane>* planes_W) {
  const world::SupportPlane seen_W = world::Transform(X_WC, seen.plane_C);
  const Vector3d middle_W = (seen_W.corners_A[0] + seen_W.corners_A[2]) / 2.0;
  const auto continues = [&](const world::SupportPlane& known) {
    return std::abs(known.HeightOf(middle_W)) < kSameLevel_m &&
           known.Covers(middle_W, kPlaneReach_m);
  };
  const auto known = std::find_if(planes_W->begin(), planes_W->end(), continues);
  const auto k = static_cast<std::size_t>(known - planes_W->begin());
  if (known == planes_W->end()) {
    planes_W->push_back(seen_W);
    further_points_W_.emplace_back();
  }
  Extend(seen.points_C, X_WC, &further_points_W_[k], &(*planes_W)[k]);
}

}  // namespace secondlook::apps
