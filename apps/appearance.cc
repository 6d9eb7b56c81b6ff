#include "apps/appearance.h"

#include <algorithm>
#include <vector>

#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "lib/common/error.h"
#include "lib/fusion/dempster_shafer.h"

namespace secondlook::apps {
namespace {

constexpr int kMinSide_px = 12;

}  // namespace

cv::Rect BoundingBox(const world::Cluster& cluster, int image_width) {
  cv::Rect box;
  for (const int pixel : cluster.pixels) {
    box |= cv::Rect(pixel % image_width, pixel / image_width, 1, 1);
  }
  return box;
}

world::MassFunction LooksOf(const world::Cluster& cluster, const cv::Mat& color,
                            const perception::Classifier& classifier) {
  if (color.empty()) return {};
  const cv::Rect box = BoundingBox(cluster, color.cols);
  if (std::min(box.width, box.height) < kMinSide_px) return {};
  const std::vector<double> probabilities = classifier.Classify(color(box));
  world::MassFunction masses;
  masses.omega = 0.0;
  for (std::size_t i = 0; i < probabilities.size(); ++i) {
    const std::string& c = classifier.classes()[i];
    const bool of_nothing = c == perception::kUnknownClass || c == perception::kBackgroundClass;
    (of_nothing ? masses.omega : masses.singletons[c]) += probabilities[i];
  }
  return fusion::Discounted(masses, classifier.held_out_accuracy());
}

fusion::Appearance AppearanceOf(const world::ObjectBelief& object, const world::SceneBelief& belief,
                                const std::vector<perception::RecognitionModel>& models,
                                double view_reliability) {
  fusion::Appearance appearance;
  for (const world::Sighting& sighting : object.sightings) {
    const world::MassFunction& looks =
        belief.views[sighting.view].detections[sighting.detection].appearance;
    if (looks.singletons.empty()) continue;
    appearance.masses =
        fusion::Combine(appearance.masses, fusion::Discounted(looks, view_reliability));
  }
  for (const auto& [c, mass] : appearance.masses.singletons) {
    if (perception::FindModel(models, c) == nullptr) appearance.without_model.insert(c);
  }
  return appearance;
}

std::unique_ptr<perception::Classifier> LoadMissionClassifier(
    const std::filesystem::path& path, const world::ObjectDatabase& database) {
  if (path.empty()) return nullptr;
  std::unique_ptr<perception::Classifier> classifier = perception::LoadClassifier(path);
  const std::vector<std::string>& classes = classifier->classes();
  std::vector<std::string> by_shape_alone;
  for (const world::ObjectModel& model : database.models()) {
    if (std::find(classes.begin(), classes.end(), model.name) == classes.end()) {
      by_shape_alone.push_back(model.name);
    }
  }
  if (by_shape_alone.size() == database.models().size()) {
    Throw<ConfigError>(
        "{}: tells of {}, which are none of the models {}; train it on pictures of these, each in "
        "a folder with the model's name",
        path.string(), fmt::join(classes, ", "), fmt::join(by_shape_alone, ", "));
  }
  if (!by_shape_alone.empty()) {
    spdlog::warn("{}: does not tell of {}, which are known by shape alone", path.string(),
                 fmt::join(by_shape_alone, ", "));
  }
  return classifier;
}

}  // namespace secondlook::apps
