#pragma once

#include <vector>

#include "lib/geometry/camera_model.h"
#include "lib/planning/aspect_target.h"
#include "lib/planning/environment_analysis.h"

namespace secondlook::planning {

/// How much of the silhouette of `model` a view from X_WC has off its rim. The rim is one pixel
/// wide: depth cameras measure nothing there, and a hypothesis that is nearly all rim is not
/// accepted (perception::VerifyConfig::min_inner), as wires from afar. Asked of a few dozen of the
/// rays that hit: is there still surface a pixel away on all sides?
/// @param camera The real camera.
/// @param hits Where `rays` meet the model, one a ray.
/// @return in [0, 1]; 0 when no ray hits.
double InnerShare(const PosedModel& model, const geometry::CameraModel& camera, const Pose& X_WC,
                  const std::vector<BoxRay>& rays, const std::vector<geometry::RayHit>& hits);

}  // namespace secondlook::planning
