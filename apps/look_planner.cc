#include "apps/look_planner.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "apps/guiding_hypotheses.h"
#include "apps/one_shot_look.h"
#include "lib/common/parallel.h"
#include "lib/fusion/dempster_shafer.h"
#include "lib/planning/collision.h"
#include "lib/planning/cost_map.h"
#include "lib/planning/look_check.h"
#include "lib/planning/path.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using world::LookWay;
using world::ObjectBelief;

/// Of so many looks, the best for their own sake, it is asked what else they show.
constexpr std::size_t kLooksBeside = 8;
/// Cameras no farther apart see the same [m].
constexpr double kSamePlace = 0.05;
/// Nothing is thinner than this [m].
constexpr double kThinnest = 0.005;

/// `box` with edges that a ray can meet: what lies flat may have been measured without any height.
Eigen::AlignedBox3d WithBody(const Eigen::AlignedBox3d& box) {
  if (box.sizes().minCoeff() >= kThinnest) return box;
  const Vector3d half = 0.5 * box.sizes().cwiseMax(kThinnest);
  return {box.center() - half, box.center() + half};
}

/// The arm is lost out of the cylinder that the base drives as.
void RefuseToDrive(world::Look* look) {
  if (look->path_W.empty() || !look->feasible) return;
  look->feasible =
      planning::AddCheck("arm folded", false, "the arm is lost, and not folded: no driving", look);
}

}  // namespace

Eigen::AlignedBox3d PlacedBox(const geometry::Mesh& mesh, const Pose& X_WM) {
  const Eigen::AlignedBox3d box_M = geometry::Bounds(mesh);
  Eigen::AlignedBox3d box_W;
  for (int corner = 0; corner < 8; ++corner) {
    box_W.extend(X_WM * box_M.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
  }
  return box_W;
}

LookPlanner::LookPlanner(const LookConfig& config, const UnderstandingConfig& understanding,
                         planning::CameraCarrier carrier)
    : config_(config),
      conclude_(understanding.conclude),
      registration_(understanding.registration),
      carrier_(std::move(carrier)) {
  config_.Validate();
}

std::vector<world::Look> LookPlanner::Candidates(const SceneUnderstanding& scene,
                                                 const world::Task& task, const Question& question,
                                                 const Stance& stance, Rng* rng) {
  const world::VoxelSpace& space = question.map != nullptr ? *question.map : scene.space();
  const world::SupportPlane& plane_W = *scene.belief().plane_W;
  const std::vector<world::SupportPlane> supports_W{plane_W};
  Vector3d center_W = Vector3d::Zero();
  for (const Vector3d& corner : plane_W.corners_A) center_W += corner / 4.0;
  planning::CostMap map(space, supports_W, carrier_.base, center_W.head<2>(), config_.cost_map);
  std::erase_if(blocked_, [&](const Blocked& blocked) { return blocked.until <= stance.time; });
  for (const Blocked& blocked : blocked_) map.Block(blocked.p_W, config_.blocked_radius_m);
  const planning::CollisionChecker collision(space, supports_W, carrier_.base, config_.cost_map);
  const planning::Routes routes(map, stance.X_WB, carrier_.base);
  const planning::Reach reach{collision, routes, stance.head};

  std::vector<planning::AspectTarget> targets;
  for (const ObjectBelief* object : question.open)
    targets.push_back(TargetFor(scene, task, *object));
  for (const auto& box_W : question.hidden_W) targets.push_back(TargetFor(scene, box_W));

  const planning::CommonGround ground(scene.reference().Points(), registration_);
  std::optional<planning::ArmCollision> around_arm;
  if (arm_ && arm_looks_ && !targets.empty())
    around_arm = arm_->CollisionAt(stance, space, supports_W);
  const hal::JointTrajectory folding = arm_ ? arm_->Folding(stance.q) : hal::JointTrajectory{};
  std::vector<world::Look> looks;
  std::vector<int> target_of;  // one a look
  for (int t = 0; t < static_cast<int>(targets.size()); ++t) {
    const auto add = [&](std::vector<world::Look> scored) {
      target_of.resize(target_of.size() + scored.size(), t);
      std::move(scored.begin(), scored.end(), std::back_inserter(looks));
    };
    const int id = targets[t].id;
    const Eigen::AlignedBox3d& box_W = targets[t].box_W;
    std::vector<world::Look> views =
        planning::CandidateViews(box_W.center(), id, carrier_, reach, config_.views);
    for (world::Look& view : planning::PlacedViews(box_W, id, carrier_, reach, config_.views)) {
      views.push_back(std::move(view));
    }
    for (world::Look& view : views) {
      if (arm_lost_) {
        if (!folding.knots.empty()) RefuseToDrive(&view);
        continue;
      }
      view.arm_motion = folding;
      view.seconds += folding.seconds();
    }
    add(Score(space, targets[t], ground, LookWay::kHead, std::move(views), rng));
    if (!arm_ || !arm_looks_) continue;
    add(Score(space, targets[t], ground, LookWay::kArm,
              arm_->Views(box_W.center(), id, stance, *around_arm), rng));
  }
  if (classifier_ != nullptr && ByLoss()) {
    for (int t = 0; t < static_cast<int>(question.open.size()); ++t) {
      const std::optional<world::Look> look = OneShotLook(
          scene.belief(), *question.open[t], task, *classifier_, conclude_.view_reliability,
          config_.aspect_graph.loss, config_.aspect_graph.look_seconds, looks);
      if (!look) continue;
      looks.push_back(*look);
      target_of.push_back(t);
    }
  }
  if (ByLoss()) AddGainsBeside(space, ground, targets, target_of, &looks);
  return looks;
}

bool LookPlanner::ByLoss() const {
  return planning::ParseLookStrategy(config_.aspect_graph.strategy) ==
         planning::LookStrategy::kExpectedLoss;
}

const hal::CameraInfo& LookPlanner::CameraOf(LookWay way) const {
  return way == LookWay::kArm ? arm_->camera() : carrier_.camera;
}

/// The views of one target that are all reached in one way, scored.
std::vector<world::Look> LookPlanner::Score(const world::VoxelSpace& space,
                                            const planning::AspectTarget& target,
                                            const planning::CommonGround& ground, LookWay way,
                                            std::vector<world::Look> views, Rng* rng) const {
  planning::AspectGraph graph = planning::ScoreAspectGraph(
      space, CameraOf(way).model, target, std::move(views), rng, config_.aspect_graph);
  for (world::Look& look : graph.looks) {
    if (look.feasible) CheckNotInVain(&look);
    if (look.feasible) CheckWithinWorkspace(&look);
    look.kind = target.id < 0 ? "hidden_space" : "aspect_graph";
  }
  if (!ByLoss()) return std::move(graph.looks);
  ParallelFor(static_cast<int>(graph.looks.size()), [&](int i) {
    if (graph.looks[i].feasible) WeighByCommonGround(ground, target, &graph.looks[i]);
  });
  return std::move(graph.looks);
}

/// Whoever has learned nothing there, with nothing moved since, learns nothing there again.
void LookPlanner::CheckNotInVain(world::Look* look) const {
  const auto same = std::find_if(
      vain_views_W_.begin(), vain_views_W_.end(),
      [&](const Vector3d& p) { return (look->X_WC.translation() - p).norm() < kSamePlace; });
  if (same == vain_views_W_.end()) return;
  look->feasible =
      planning::AddCheck("not in vain", false,
                         fmt::format("a view from ({:.2f}, {:.2f}, {:.2f}) m taught nothing",
                                     same->x(), same->y(), same->z()),
                         look);
}

void LookPlanner::CheckWithinWorkspace(world::Look* look) const {
  if (!workspace_) return;
  const auto out = [&](const Pose2& pose) { return !workspace_->Contains(pose.x, pose.y); };
  const auto waypoint = std::find_if(look->path_W.begin(), look->path_W.end(), out);
  if (waypoint == look->path_W.end()) return;
  look->feasible = planning::AddCheck(
      "workspace", false,
      fmt::format("its way leads through ({:.2f}, {:.2f}) m, out of safety.limits.workspace",
                  waypoint->x, waypoint->y),
      look);
}

/// A view that cannot be registered to the map brings nothing. One that shares little with the map
/// is registered by what it recognises, if the target is one of its hypotheses.
void LookPlanner::WeighByCommonGround(const planning::CommonGround& ground,
                                      const planning::AspectTarget& target,
                                      world::Look* look) const {
  double known = 0.0;
  for (const planning::PosedModel& model : target.hypotheses) known += model.belief;
  const double pairs = ground.Pairs(look->X_WC, CameraOf(look->way));
  const double shares = ground.ChanceOf(pairs);
  if (shares == 1.0) return;
  const double chance = shares + (1.0 - shares) * std::min(known, 1.0);
  look->checks.push_back(
      {"common ground", true,
       fmt::format("{:.0f} pairs with the map of the {} that registration wants: "
                   "gain {:.3g} with a chance of {:.2f}",
                   pairs, registration_.min_pairs, look->gain, chance)});
  look->gain *= chance;
  look->score *= chance;
}

/// A look shows more than it is for: adds to the best few what they bring to the other targets.
void LookPlanner::AddGainsBeside(const world::VoxelSpace& space,
                                 const planning::CommonGround& ground,
                                 const std::vector<planning::AspectTarget>& targets,
                                 const std::vector<int>& target_of,
                                 std::vector<world::Look>* looks) const {
  std::vector<int> best;
  for (int i = 0; i < static_cast<int>(looks->size()); ++i) {
    if ((*looks)[i].feasible) best.push_back(i);
  }
  std::stable_sort(best.begin(), best.end(),
                   [&](int a, int b) { return (*looks)[a].score > (*looks)[b].score; });
  best.resize(std::min(best.size(), kLooksBeside));

  planning::AspectGraphConfig config = config_.aspect_graph;
  config.look_ahead.firsts = 0;
  Rng unused(0);
  std::vector<LookWay> ways{LookWay::kHead};
  if (arm_) ways.push_back(LookWay::kArm);
  std::vector<double> beside(best.size(), 0.0);
  for (int t = 0; t < static_cast<int>(targets.size()); ++t) {
    for (const LookWay way : ways) {
      const auto counts = [&](int i) { return target_of[i] != t && (*looks)[i].way == way; };
      std::vector<world::Look> seen;
      for (const int i : best) {
        seen.push_back((*looks)[i]);
        seen.back().feasible = counts(i);
      }
      const planning::AspectGraph graph = planning::ScoreAspectGraph(
          space, CameraOf(way).model, targets[t], std::move(seen), &unused, config);
      for (std::size_t k = 0; k < best.size(); ++k) {
        if (counts(best[k])) beside[k] += graph.looks[k].gain;
      }
    }
  }
  for (std::size_t k = 0; k < best.size(); ++k) {
    if (!(beside[k] > 0.0)) continue;
    world::Look& look = (*looks)[best[k]];
    beside[k] *= ground.Chance(look.X_WC, CameraOf(look.way));
    look.checks.push_back({"sees beside", true,
                           fmt::format("gain {:.3g} at the target and {:.3g} at other things",
                                       look.gain, beside[k])});
    look.gain += beside[k];
    look.score += beside[k] / (look.seconds + config.look_seconds);
  }
}

planning::AspectTarget LookPlanner::TargetFor(const SceneUnderstanding& scene,
                                              const world::Task& task, const ObjectBelief& object) {
  planning::AspectTarget target;
  target.id = object.id;
  target.box_W = object.extent_W;
  target.none = std::min(fusion::NormalisedIgnorance(object.masses), task.confidence);
  const auto add = [&](const GuidingHypothesis& guiding) {
    const world::PoseHypothesis& h = *guiding.hypothesis;
    const perception::RecognitionModel* model = perception::FindModel(scene.models(), h.model);
    // What keeps an object open although its class is sure enough is doubt as well.
    const double needed = NeededProbability(h, object, task, conclude_);
    target.hypotheses.push_back(
        {&model->mesh, &CasterOf(*model), h.X_WM, std::min(guiding.probability, needed), needed});
  };
  const std::vector<GuidingHypothesis> likely = LikelyHypotheses(object, conclude_);
  for (const GuidingHypothesis& guiding : likely) {
    add(guiding);
    target.box_W.extend(PlacedBox(*target.hypotheses.back().mesh, guiding.hypothesis->X_WM));
  }
  // Rivals are told apart where the target is; that they may reach beyond it makes it no larger.
  if (ByLoss()) std::ranges::for_each(Rivals(object, likely, conclude_), add);
  target.box_W = WithBody(target.box_W);
  for (const world::Sighting& sighting : object.sightings) {
    const Pose& X_WC = scene.belief().views[sighting.view].X_WC;
    target.seen_from_W.push_back((X_WC.translation() - object.extent_W.center()).normalized());
  }
  for (const Vector3d& p : vain_views_W_) {
    target.seen_from_W.push_back((p - object.extent_W.center()).normalized());
  }
  return target;
}

planning::AspectTarget LookPlanner::TargetFor(const SceneUnderstanding& scene,
                                              const Eigen::AlignedBox3d& hidden_W) const {
  planning::AspectTarget target;
  target.box_W = WithBody(hidden_W);
  for (const world::Observation& view : scene.belief().views) {
    target.seen_from_W.push_back((view.X_WC.translation() - hidden_W.center()).normalized());
  }
  for (const Vector3d& p : vain_views_W_) {
    target.seen_from_W.push_back((p - hidden_W.center()).normalized());
  }
  return target;
}

const geometry::RayCaster& LookPlanner::CasterOf(const perception::RecognitionModel& model) {
  return ray_casters_.try_emplace(model.name, model.mesh).first->second;
}

}  // namespace secondlook::apps
