#include "apps/look_planner.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
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
/// What a scan shows is asked of so many of its rays along each edge of the picture, as a share…
constexpr double kScanRays = 0.25;
/// …which pass so near to what is seen of the thing [m].
constexpr double kAroundScan = 0.08;
/// From one scan of a fixed ring to the next [rad].
constexpr double kRingStep = std::numbers::pi / 4.0;
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

/// The part of the picture that shows `box_W` and what is around it, with fewer rays.
geometry::CameraModel RaysAt(const Eigen::AlignedBox3d& box_W, const geometry::CameraModel& camera,
                             const Pose& X_WC) {
  geometry::CameraModel part = camera.Scaled(kScanRays);
  Eigen::AlignedBox2d pixels;
  for (int i = 0; i < 8; ++i) {
    const auto corner = static_cast<Eigen::AlignedBox3d::CornerType>(i);
    const Vector3d p_C = X_WC.inverse() * box_W.corner(corner);
    if (!(p_C.z() > kAroundScan)) return part;
    const Eigen::Vector2d at(part.fx * p_C.x() / p_C.z() + part.cx,
                             part.fy * p_C.y() / p_C.z() + part.cy);
    const Eigen::Vector2d around = kAroundScan / p_C.z() * Eigen::Vector2d(part.fx, part.fy);
    pixels.extend(at - around);
    pixels.extend(at + around);
  }
  const Eigen::Vector2i low = pixels.min().cwiseMax(0.0).cast<int>();
  part.width = std::min(part.width, static_cast<int>(std::ceil(pixels.max().x())) + 1) - low.x();
  part.height = std::min(part.height, static_cast<int>(std::ceil(pixels.max().y())) + 1) - low.y();
  part.cx -= low.x();
  part.cy -= low.y();
  return part;
}

/// How far the direction of `look` is from the next of a ring round the thing [rad].
double OffFixedStep(const ScanTarget& target, const world::Look& look) {
  const auto azimuth = [&](const Vector3d& p_W) {
    const Vector3d way_W = p_W - target.box_W.center();
    return std::atan2(way_W.y(), way_W.x());
  };
  return std::abs(WrapAngle(azimuth(look.X_WC.translation()) - azimuth(target.last_W) - kRingStep));
}

/// A scan from there could not be fused, so the next could not either.
void CheckNotRefused(const ScanTarget& target, world::Look* look) {
  for (const Vector3d& p : target.refused_W) {
    if ((look->X_WC.translation() - p).norm() >= kSamePlace) continue;
    look->feasible = planning::AddCheck(
        "not refused", false,
        fmt::format("a scan from ({:.2f}, {:.2f}, {:.2f}) m was refused", p.x(), p.y(), p.z()),
        look);
    return;
  }
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
  if (arm_ && arm_looks_ && (!targets.empty() || question.scan))
    around_arm = arm_->CollisionAt(stance, space, supports_W);
  const hal::JointTrajectory folding = arm_ ? arm_->Folding(stance.q) : hal::JointTrajectory{};
  const auto by_head = [&](const Eigen::AlignedBox3d& box_W, int id) {
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
    return views;
  };
  std::vector<world::Look> looks;
  std::vector<int> target_of;  // one a look
  for (int t = 0; t < static_cast<int>(targets.size()); ++t) {
    const auto add = [&](std::vector<world::Look> scored) {
      target_of.resize(target_of.size() + scored.size(), t);
      std::move(scored.begin(), scored.end(), std::back_inserter(looks));
    };
    const int id = targets[t].id;
    const Eigen::AlignedBox3d& box_W = targets[t].box_W;
    add(Score(space, targets[t], ground, LookWay::kHead, by_head(box_W, id), rng));
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
  if (question.scan) {
    const ScanTarget& target = *question.scan;
    const Eigen::AlignedBox3d box_W = WithBody(target.box_W);
    std::vector<world::Look> views = by_head(box_W, target.object);
    if (arm_ && arm_looks_) {
      for (world::Look& view : arm_->Views(box_W.center(), target.object, stance, *around_arm)) {
        views.push_back(std::move(view));
      }
    }
    for (world::Look& look : ScoreScans(target, ground, std::move(views), rng)) {
      looks.push_back(std::move(look));
    }
  }
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

/// The views of a thing that is being modelled, scored. When none shows enough of its surface for
/// the first time, none is possible.
std::vector<world::Look> LookPlanner::ScoreScans(const ScanTarget& target,
                                                 const planning::CommonGround& ground,
                                                 std::vector<world::Look> views, Rng* rng) const {
  for (world::Look& look : views) CheckScan(target, &look);
  std::vector<planning::ScanGain> gains(views.size());
  ParallelFor(static_cast<int>(views.size()), [&](int i) {
    if (!views[i].feasible) return;
    const geometry::CameraModel& camera = CameraOf(views[i].way).model;
    gains[i] = target.gain->Measure(RaysAt(target.box_W, camera, views[i].X_WC), views[i].X_WC);
  });
  double most = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!(target.surface > 0.0)) break;
    views[i].visibility = std::min(gains[i].new_surface / target.surface, 1.0);
    most = std::max(most, views[i].visibility);
  }
  const std::vector<double> utilities =
      planning::KriegelUtilities(gains, target.scans, modelling_.gain);
  for (std::size_t i = 0; i < views.size(); ++i) {
    world::Look& look = views[i];
    if (!look.feasible) continue;
    look.feasible = planning::AddCheck(
        "new surface", most >= modelling_.worthwhile,
        fmt::format("adds {:.1f} % to the surface that is seen, the best of all {:.1f} %; "
                    "{:.1f} % are worth a scan",
                    100.0 * look.visibility, 100.0 * most, 100.0 * modelling_.worthwhile),
        &look);
    look.gain = config_.aspect_graph.loss.incomplete * look.visibility;
    look.score = look.gain / (look.seconds + config_.aspect_graph.look_seconds);
    switch (ParseScanStrategy(modelling_.strategy)) {
      case ScanStrategy::kNewSurface:
        WeighByCommonGround(ground, {}, &look);
        break;
      case ScanStrategy::kKriegel:
        look.score = utilities[i];
        break;
      case ScanStrategy::kRandom:
        look.score = rng->Uniform(0.0, 1.0);
        break;
      case ScanStrategy::kFixedStep:
        look.score = 1.0 / (1.0 + OffFixedStep(target, look));
        break;
    }
  }
  return views;
}

/// What any scan must pass, beside that it can be reached.
void LookPlanner::CheckScan(const ScanTarget& target, world::Look* look) const {
  look->kind = "scan";
  if (look->feasible) CheckNotRefused(target, look);
  if (look->feasible) CheckNotInVain(look);
  if (look->feasible) CheckWithinWorkspace(look);
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

void LookPlanner::KeepWithin(const hal::GuardConfig& limits) {
  workspace_ = limits.workspace;
  if (arm_ && limits.arm_workspace) arm_->KeepWithin(limits.arm_workspace->box_B());
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
