#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <opencv2/core/mat.hpp>

#include "lib/fusion/conclude.h"
#include "lib/perception/appearance/classifier.h"
#include "lib/perception/recognition_model.h"
#include "lib/world/mass_function.h"
#include "lib/world/object_belief.h"
#include "lib/world/object_database.h"
#include "lib/world/scene_belief.h"

namespace secondlook::apps {

/// The smallest rectangle of an image around the pixels of `cluster`, which is what a classifier is
/// shown of a thing; empty without pixels.
cv::Rect BoundingBox(const world::Cluster& cluster, int image_width);

/// What `classifier` says of the thing `cluster` in the image `color` (CV_8UC3, RGB): its
/// probabilities as masses, those of "unknown" and of the background as m(Omega) (Hoseini 2018,
/// 2.2), discounted by how far it is right on images kept out of its training. Vacuous where there
/// is no colour, or the thing is smaller than 12 pixels in width or height.
world::MassFunction LooksOf(const world::Cluster& cluster, const cv::Mat& color,
                            const perception::Classifier& classifier);

/// What all views of `belief` that show `object` say of its looks. Each counts with the probability
/// `view_reliability`: views share errors. `models` are those whose shape is known.
fusion::Appearance AppearanceOf(const world::ObjectBelief& object, const world::SceneBelief& belief,
                                const std::vector<perception::RecognitionModel>& models,
                                double view_reliability);

/// The classifier of the model file `path`, for a mission with this database; null for "". Warns of
/// the models that it does not tell of: these are known by shape alone.
/// @throws ConfigError as LoadClassifier(), and naming the file and both lists when it tells of
/// none of the models.
std::unique_ptr<perception::Classifier> LoadMissionClassifier(
    const std::filesystem::path& path, const world::ObjectDatabase& database);

}  // namespace secondlook::apps
