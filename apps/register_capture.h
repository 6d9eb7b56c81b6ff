#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "apps/capture.h"
#include "apps/mission_config.h"
#include "apps/scene_map.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/register_view.h"
#include "lib/perception/segment.h"
#include "lib/world/support_plane.h"

namespace secondlook::apps {

/// Where `capture`, cut into `cut`, with the surface `points_C`, was taken from. The first view
/// defines the map; the others are registered to it. What a view recognises has sides that it does
/// not see and another view did: one that shares too little with the map is registered by these,
/// too. Everything else is weighed against what is known of the capture's pose.
/// @param plane_W None before the first view.
perception::ViewRegistration RegisterCapture(
    const Capture& capture, const perception::Segmentation& cut,
    std::vector<perception::SurfacePoint> points_C,
    const std::optional<world::SupportPlane>& plane_W, const SceneMap& map,
    const std::vector<perception::RecognitionModel>& models, const UnderstandingConfig& config);

/// The covariance of where a view's points lie in the map [m^2]: by its registration, at the middle
/// of the table, and by the map's own error.
Eigen::Matrix3d PointError(const perception::ViewRegistration& registration,
                           const std::optional<world::SupportPlane>& plane_W);

}  // namespace secondlook::apps
