#pragma once

#include <optional>
#include <vector>

#include "apps/experiments/free_camera.h"
#include "lib/perception/regroup.h"
#include "lib/perception/view.h"
#include "lib/world/hypothesis.h"
#include "lib/world/object_database.h"
#include "lib/world/observation.h"

namespace secondlook::apps {

/// A photo, cut into the things on the support plane.
struct CutPhoto {
  perception::View view;
  std::vector<world::Cluster> clusters;  ///< That `view` is labelled with, in order.
};

/// What a mission's segmentation makes of one view; empty when it finds no support plane.
std::optional<CutPhoto> Cut(const Photo& photo, const geometry::CameraModel& camera);

/// What a mission's segmentation and recognition make of one view, all by itself; nothing where it
/// finds no support plane.
perception::Regrouped Detect(const Photo& photo, const geometry::CameraModel& camera,
                             const std::vector<perception::RecognitionModel>& models);

/// The hypotheses that are chosen, one for each detection that has one.
std::vector<world::Hypothesis> Chosen(const perception::Regrouped& found);

/// The models of the objects in `scene`, ready for recognition.
/// @throws ConfigError for an object that `database` does not hold.
std::vector<perception::RecognitionModel> ModelsOf(const sim::Scene& scene,
                                                   const world::ObjectDatabase& database);

}  // namespace secondlook::apps
