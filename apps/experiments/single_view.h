#pragma once

#include <optional>
#include <vector>

#include "apps/experiments/free_camera.h"
#include "lib/perception/recognise.h"
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

/// What a mission's segmentation and recognition make of one view, all by itself.
std::vector<world::Detection> Detect(const Photo& photo, const geometry::CameraModel& camera,
                                     const std::vector<perception::RecognitionModel>& models);

/// What is beyond doubt in the view as a whole (perception::ChooseTogether), by the configuration
/// of a mission.
std::vector<perception::Choice> Choose(const std::vector<world::Detection>& detections,
                                       const std::vector<perception::RecognitionModel>& models);

/// The hypotheses that are chosen, one for each detection that has one.
std::vector<world::Hypothesis> Chosen(const std::vector<world::Detection>& detections,
                                      const std::vector<perception::Choice>& choices);

/// The models of the objects in `scene`, ready for recognition.
/// @throws ConfigError for an object that `database` does not hold.
std::vector<perception::RecognitionModel> ModelsOf(const sim::Scene& scene,
                                                   const world::ObjectDatabase& database);

}  // namespace secondlook::apps
