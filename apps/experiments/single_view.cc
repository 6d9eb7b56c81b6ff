#include "apps/experiments/single_view.h"

#include <utility>

#include "apps/mission_config.h"
#include "lib/common/error.h"
#include "lib/perception/segment.h"

namespace secondlook::apps {

std::optional<CutPhoto> Cut(const Photo& photo, const geometry::CameraModel& camera) {
  const UnderstandingConfig config;
  const Eigen::Vector3d up_C = photo.X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
  const double max_drop = photo.X_WC.translation().z() - config.floor_clearance_m;
  perception::Segmentation cut = perception::Segment(geometry::Deproject(photo.frame.depth, camera),
                                                     up_C, config.segment, max_drop);
  if (!cut.plane_C) return std::nullopt;
  perception::View view = perception::MakeView(photo.frame.color, photo.frame.depth, camera,
                                               *cut.plane_C, cut.clusters);
  return CutPhoto{std::move(view), std::move(cut.clusters)};
}

perception::Regrouped Detect(const Photo& photo, const geometry::CameraModel& camera,
                             const std::vector<perception::RecognitionModel>& models) {
  const std::optional<CutPhoto> cut = Cut(photo, camera);
  if (!cut) return {};
  return perception::RecogniseRegrouping(cut->view, cut->clusters, models,
                                         UnderstandingConfig().recognise);
}

std::vector<world::Hypothesis> Chosen(const perception::Regrouped& found) {
  std::vector<world::Hypothesis> chosen;
  for (std::size_t i = 0; i < found.detections.size(); ++i) {
    const int h = found.choices[i].hypothesis;
    if (h >= 0) chosen.push_back(found.detections[i].hypotheses[h]);
  }
  return chosen;
}

std::vector<perception::RecognitionModel> ModelsOf(const sim::Scene& scene,
                                                   const world::ObjectDatabase& database) {
  std::vector<world::ObjectModel> drawn;
  for (const sim::SceneObject& object : scene.objects) {
    const world::ObjectModel* model = database.Find(object.name);
    if (model == nullptr) {
      Throw<ConfigError>("scene '{}': object '{}' is not in the database of models", scene.name,
                         object.name);
    }
    drawn.push_back(*model);
  }
  return perception::TrainModels(world::ObjectDatabase(std::move(drawn)));
}

}  // namespace secondlook::apps
