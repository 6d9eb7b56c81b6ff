#pragma once

#include <vector>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/geometry/ray_caster.h"
#include "lib/planning/aspect_graph_config.h"
#include "lib/planning/aspect_target.h"
#include "lib/planning/environment_analysis.h"

namespace secondlook::planning {

/// How much of one hypothesis a candidate would see.
struct ModelVisibility {
  double box_share{};   ///< Of the rays to the target's box that arrive and hit the model, each
                        ///< counted with its chance to survive, in [0, 1].
  double seen{};        ///< Of the rays that would hit the model alone, the share that arrives,
                        ///< each counted likewise, in [0, 1]; a thin thing fills little of its box.
  double view_share{};  ///< Of all rays of the camera, unknown space counted as free: the paper's
                        ///< visibility, in [0, 1].
  double area{};        ///< Of the model's surface that these rays see [m^2].
};

/// Of the rays to something, how many there are and on how many something new is seen: only past
/// what is known to be free, or also through what is unknown.
struct NewsRays {
  double all{};
  double through_free{};
  double arriving{};

  void Add(const BoxRay& ray, bool news) {
    all += 1.0;
    if (!news || ray.stopped) return;
    arriving += 1.0;
    if (!ray.through_unknown) through_free += 1.0;
  }
};

/// Where the rays of a camera at X_WC meet the model; one a ray.
std::vector<geometry::RayHit> CastAt(const PosedModel& model, const Pose& X_WC,
                                     const std::vector<BoxRay>& rays);

/// The model analysis of one candidate for one hypothesis (McGreavy 2016, Section 4).
ModelVisibility Visibility(const PosedModel& model, const geometry::CameraModel& camera,
                           const std::vector<BoxRay>& rays,
                           const std::vector<geometry::RayHit>& hits);

/// Sum minus the differences (McGreavy 2016, Multi-object Disambiguation).
double CompromiseScore(const std::vector<ModelVisibility>& models);

/// The rays to either model, and those on which the camera would measure something else.
NewsRays DifferingRays(const PosedModel& a, const std::vector<geometry::RayHit>& hits_a,
                       const PosedModel& b, const std::vector<geometry::RayHit>& hits_b,
                       const std::vector<BoxRay>& rays, const AspectGraphConfig& config);

/// The rays to the model; to the box when `hits` is null.
NewsRays RaysTo(const std::vector<geometry::RayHit>* hits, const std::vector<BoxRay>& rays);

}  // namespace secondlook::planning
