#include "apps/one_shot_look.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "apps/appearance.h"
#include "lib/fusion/dempster_shafer.h"
#include "lib/planning/tile_view.h"
#include "lib/planning/tile_vote.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using planning::Criterion;
using planning::Tile;

/// Classes believed less are no alternatives.
constexpr double kMinBelief = 0.01;
/// A look goes to the side of a tile when its direction is nearer to it than to the next one.
const double kSameSide = std::cos(std::numbers::pi / 8.0);
/// A camera right before the object is on no side of it.
constexpr double kAside = 0.3;

/// The classes of ClassBelief(), in its order.
std::vector<std::string> Alternatives(const world::ObjectBelief& object) {
  std::vector<std::string> classes;
  for (const auto& [c, mass] : object.masses.singletons) {
    if (fusion::NormalisedBelief(object.masses, c) >= kMinBelief) classes.push_back(c);
  }
  return classes;
}

/// The object as its newest picture shows it.
planning::ObjectCrop NewestCrop(const world::Observation& view, const cv::Rect& box) {
  planning::ObjectCrop crop;
  crop.color = view.frame.color(box);
  crop.depth = view.frame.depth(box).clone();
  crop.focal_length_px = view.camera.fx;
  return crop;
}

/// The look of `object` that is on the side of `tile` of the view and nearest to what TileView()
/// asks for; null when none is.
const world::Look* LookFrom(Tile tile, const world::Observation& view,
                            const world::ObjectBelief& object,
                            const std::vector<world::Look>& looks) {
  const Vector3d p_CO = view.X_WC.inverse() * object.extent_W.center();
  const Vector3d p_WV = (view.X_WC * planning::TileView(tile, p_CO, p_CO.norm())).translation();
  const world::Look* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const world::Look& look : looks) {
    if (!look.feasible || look.target != object.id) continue;
    const Vector3d from_C = (view.X_WC.inverse() * look.X_WC.translation() - p_CO).normalized();
    const Eigen::Vector2d aside = from_C.head<2>();
    if (aside.norm() < kAside) continue;
    if (aside.normalized().dot(planning::TileDirection(tile)) < kSameSide) continue;
    const double distance = (look.X_WC.translation() - p_WV).norm();
    if (distance >= least) continue;
    least = distance;
    nearest = &look;
  }
  return nearest;
}

}  // namespace

planning::Belief ClassBelief(const world::ObjectBelief& object, const world::Task& task) {
  planning::Belief belief;
  double sum = 0.0;
  for (const std::string& c : Alternatives(object)) {
    const double p = fusion::NormalisedBelief(object.masses, c);
    belief.alternatives.push_back({p, task.ConfidenceFor(c)});
    sum += p;
  }
  // What is none of them is decided by shape and views spent, not by how likely it is.
  belief.alternatives.push_back({std::max(0.0, 1.0 - sum), std::nextafter(1.0, 0.0)});
  return belief;
}

double ClassificationGain(const world::ObjectBelief& object, const world::Task& task,
                          const std::vector<std::string>& classes, double accuracy,
                          const planning::LossConfig& loss) {
  const planning::Belief belief = ClassBelief(object, task);
  const std::vector<std::string> alternatives = Alternatives(object);
  const double others = std::max<double>(1.0, static_cast<double>(classes.size()) - 1.0);
  const double wrong = std::max(1.0 - accuracy, 1e-6) / others;
  const double divergence = std::max(0.0, (accuracy - wrong) * std::log(accuracy / wrong));
  const auto told = [&](const std::string& c) {
    return std::find(classes.begin(), classes.end(), c) != classes.end();
  };
  planning::Prospect prospect;
  const auto count = static_cast<Eigen::Index>(belief.alternatives.size());
  prospect.evidence = Eigen::MatrixXd::Zero(count, count);
  for (std::size_t i = 0; i < alternatives.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!told(alternatives[i]) || !told(alternatives[j])) continue;
      const auto a = static_cast<Eigen::Index>(i);
      const auto b = static_cast<Eigen::Index>(j);
      prospect.evidence(a, b) = prospect.evidence(b, a) = divergence;
    }
  }
  return Loss(belief, loss) - ExpectedLoss(Outcomes(belief, {prospect}), loss);
}

std::optional<world::Look> OneShotLook(const world::SceneBelief& scene,
                                       const world::ObjectBelief& object, const world::Task& task,
                                       const perception::Classifier& classifier,
                                       double view_reliability, const planning::LossConfig& loss,
                                       double look_seconds, const std::vector<world::Look>& looks) {
  const std::string leader = object.LeadingClass();
  if (leader.empty() || object.sightings.empty()) return std::nullopt;
  if (fusion::NormalisedBelief(object.masses, leader) >= task.ConfidenceFor(leader)) {
    return std::nullopt;  // it is the pose that is open
  }
  const world::Sighting& newest = object.sightings.back();
  const world::Observation& view = scene.views[newest.view];
  const world::Detection& detection = view.detections[newest.detection];
  if (detection.appearance.singletons.empty()) return std::nullopt;
  const planning::ObjectCrop crop =
      NewestCrop(view, BoundingBox(detection.cluster, view.frame.color.cols));
  const planning::TileRanking ranking = planning::RankTiles(
      planning::ScoreTiles(crop, nullptr),
      {{Criterion::kVariance}, {Criterion::kMetricParallelism}, {Criterion::kLight}},
      planning::VoteRule::kBorda);
  const std::optional<Tile> tile =
      ranking.Best([&](Tile side) { return LookFrom(side, view, object, looks) != nullptr; });
  if (!tile) return std::nullopt;
  world::Look look = *LookFrom(*tile, view, object, looks);
  const double gain = ClassificationGain(object, task, classifier.classes(),
                                         classifier.held_out_accuracy() * view_reliability, loss);
  look.kind = "one_shot";
  look.checks.push_back(
      {"one-shot vote", true,
       fmt::format("the {} of view {} votes for this side: gain {:.3g} by its picture, {:.3g} by "
                   "its shape",
                   planning::TileName(*tile), newest.view, gain, look.gain)});
  if (gain > look.gain) {
    look.gain = gain;
    look.score = gain / (look.seconds + look_seconds);
  }
  return look;
}

}  // namespace secondlook::apps
