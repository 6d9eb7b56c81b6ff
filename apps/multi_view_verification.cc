#include "apps/multi_view_verification.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/appearance.h"
#include "lib/fusion/conclude.h"
#include "lib/fusion/dempster_shafer.h"
#include "lib/fusion/pose_fusion.h"
#include "lib/perception/posed_colors.h"
#include "lib/perception/refine.h"
#include "lib/perception/rival_turns.h"
#include "lib/perception/turn_by_color.h"
#include "lib/perception/verify.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using world::ObjectBelief;
using world::PoseHypothesis;

/// Two hypotheses of one model nearer than this are one: the next view's refinement bridges it.
constexpr double kSamePose_m = 0.03;
constexpr double kSamePose_rad = 0.26;
/// Two that come nearer than this are one for good.
constexpr double kOnePose_m = 0.01;
constexpr double kOnePose_rad = 0.087;
/// Refinement that moves a carried hypothesis farther has found another pose.
constexpr double kMaxRefinement_m = 0.03;
constexpr double kMaxRefinement_rad = 0.17;
constexpr int kRefineRounds = 4;
/// A verified pose is told from poses turned by so much: a little more than it may be off.
constexpr double kRivalTurn_rad = 0.12;
constexpr int kMaxTurnRounds = 5;
/// Nearer to the middle of two such turns, in shares of the turn, a pose is not moved.
constexpr double kCentred = 0.05;
/// How well views are registered to each other: what a single view's pose is worth in the map.
constexpr double kViewSigma_m = 0.004;
constexpr double kViewSigma_rad = 0.006;
/// Directions nearer than this show the same side of a thing.
constexpr double kSameSide_rad = 0.5;
/// So many points of a model are looked up in the map.
constexpr std::size_t kMapPoints = 500;

/// The covariance of a motion given in M, in W.
Eigen::Matrix<double, 6, 6> InWorld(const Eigen::Matrix<double, 6, 6>& covariance_M,
                                    const Eigen::Matrix3d& R_WM) {
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
  turn.topLeftCorner<3, 3>() = R_WM;
  turn.bottomRightCorner<3, 3>() = R_WM;
  return turn * covariance_M * turn.transpose();
}

/// The sighting of `object` in `view`. @pre there is one.
const world::Sighting& SightingIn(const ObjectBelief& object, int view) {
  return *std::find_if(object.sightings.begin(), object.sightings.end(),
                       [&](const world::Sighting& s) { return s.view == view; });
}

/// By how much the colours speak for `a` rather than `b`, two poses of `model`, where these differ:
/// summed over the views that were asked about both.
double ColorLead(const perception::RecognitionModel& model, const PoseHypothesis& a,
                 const PoseHypothesis& b, const std::vector<perception::View>& views) {
  double lead = 0.0;
  for (const world::ViewEvidence& ea : a.evidence) {
    for (const world::ViewEvidence& eb : b.evidence) {
      if (ea.view != eb.view) continue;
      const perception::View& view = views[ea.view];
      const perception::PosedColors colors(model, ea.hypothesis.X_CM, view);
      lead += colors.LogRatio({model, eb.hypothesis.X_CM, view}).value_or(0.0);
    }
  }
  return lead;
}

/// Takes from `object`, whose best hypothesis is of `model`, the other poses of it that the scores
/// leave too near to the best, and the colours where they differ do not.
std::vector<PoseHypothesis> TakeToldByColors(const fusion::ConcludeConfig& config,
                                             const perception::RecognitionModel& model,
                                             const std::vector<perception::View>& views,
                                             ObjectBelief* object) {
  const PoseHypothesis best = object->hypotheses.front();
  std::vector<PoseHypothesis> told;
  std::vector<PoseHypothesis> left{best};
  for (std::size_t i = 1; i < object->hypotheses.size(); ++i) {
    PoseHypothesis& other = object->hypotheses[i];
    const double needed = fusion::NeededLead(config, best, other);
    double lead = needed;
    if (!other.struck && other.model == best.model) lead = fusion::Lead(config, best, other);
    if (lead < needed && lead + ColorLead(model, best, other, views) >= needed) {
      other.reason = "its colours are not those of the views, where it differs from the best pose";
      told.push_back(std::move(other));
    } else {
      left.push_back(std::move(other));
    }
  }
  object->hypotheses = std::move(left);
  return told;
}

}  // namespace

MultiViewVerification::MultiViewVerification(
    const UnderstandingConfig& config, const world::Task& task,
    const std::vector<perception::RecognitionModel>& models, const world::SceneBelief& belief,
    const std::vector<perception::View>& views, const world::VoxelSpace& space)
    : config_(config),
      task_(task),
      models_(models),
      belief_(belief),
      views_(views),
      space_(space) {}

void MultiViewVerification::AddFresh(int view, const world::Detection& detection,
                                     ObjectBelief* object) const {
  const Pose& X_WC = belief_.views[view].X_WC;
  for (const world::Hypothesis& fresh : detection.hypotheses) {
    const perception::RecognitionModel& model = ModelOf(fresh.model);
    const Pose X_WM = X_WC * fresh.X_CM;
    const bool known = std::any_of(
        object->hypotheses.begin(), object->hypotheses.end(), [&](const PoseHypothesis& h) {
          if (h.struck || h.model != fresh.model) return false;
          const perception::PoseDistance distance =
              perception::DistanceUpToSymmetry(h.X_WM, X_WM, model.symmetry, model.center_M, true);
          return distance.translation < kSamePose_m && distance.rotation < kSamePose_rad;
        });
    if (known) continue;
    PoseHypothesis hypothesis;
    hypothesis.model = fresh.model;
    hypothesis.X_WM = X_WM;
    hypothesis.evidence.push_back({view, fresh});
    object->hypotheses.push_back(std::move(hypothesis));
  }
}

/// The pose of `model`, believed to stand at `X_WM`, as the view of `sighting` refines it.
Pose MultiViewVerification::RefinedIn(const world::Sighting& sighting,
                                      const perception::RecognitionModel& model, const Pose& X_WM) {
  const perception::View& view = views_[sighting.view];
  const Pose X_CM = belief_.views[sighting.view].X_WC.inverse() * X_WM;
  Pose refined =
      perception::RefinePose(model, X_CM, view, sighting.detection, kRefineRounds, &rasteriser_);
  if (model.symmetry.axis && !model.symmetry.axis_keeps_color) {
    refined = perception::PolishByColor(model, refined, view, sighting.detection);
  }
  const double moved = (refined * model.center_M - X_CM * model.center_M).norm();
  const bool another_pose = moved > kMaxRefinement_m ||
                            RotationDistance(refined.linear(), X_CM.linear()) > kMaxRefinement_rad;
  return another_pose ? X_CM : refined;
}

/// What the view of `sighting` says of `model` at X_CM.
world::ViewEvidence MultiViewVerification::Ask(const world::Sighting& sighting,
                                               const perception::RecognitionModel& model,
                                               const Pose& X_CM) {
  const perception::View& view = views_[sighting.view];
  const world::Cluster& cluster =
      belief_.views[sighting.view].detections[sighting.detection].cluster;
  world::ViewEvidence evidence{sighting.view, {model.name, X_CM, 0.0, {}}};
  evidence.hypothesis.verification =
      perception::Verify(model, X_CM, view, sighting.detection,
                         perception::InnerPixels(view, sighting.detection, cluster),
                         config_.recognise.verify, &rasteriser_, &evidence.hypothesis.score);
  return evidence;
}

/// `best` with its model turned by X_MS, as the views that `best` rests on see it.
PoseHypothesis MultiViewVerification::Turned(const ObjectBelief& object, const PoseHypothesis& best,
                                             const Pose& X_MS) {
  const perception::RecognitionModel& model = ModelOf(best.model);
  PoseHypothesis turned;
  turned.model = best.model;
  turned.X_WM = best.X_WM * X_MS;
  for (const world::ViewEvidence& e : best.evidence) {
    turned.evidence.push_back(Ask(SightingIn(object, e.view), model, e.hypothesis.X_CM * X_MS));
  }
  return turned;
}

/// `best` refined in all its views together, colour included; empty when the views prefer it as it
/// was, or it becomes another pose.
std::optional<PoseHypothesis> MultiViewVerification::RefinedTogether(const ObjectBelief& object,
                                                                     const PoseHypothesis& best) {
  const perception::RecognitionModel& model = ModelOf(best.model);
  std::vector<perception::PlacedModel> placed;
  for (const world::ViewEvidence& e : best.evidence) {
    placed.push_back({&views_[e.view], SightingIn(object, e.view).detection,
                      belief_.views[e.view].X_WC.inverse() * best.X_WM});
  }
  const perception::JointPose joint = perception::RefineTogether(
      model, placed, {kViewSigma_rad, kViewSigma_m}, kRefineRounds, &rasteriser_);
  PoseHypothesis refined = best;
  refined.X_WM = best.X_WM * joint.X_MS;
  const perception::PoseDistance moved = perception::DistanceUpToSymmetry(
      best.X_WM, refined.X_WM, model.symmetry, model.center_M, true);
  const bool another_pose =
      moved.translation > kOnePose_m || moved.rotation > kMaxRefinement_rad ||
      perception::LeavesItsRest(model, best.X_WM, joint.X_MS, belief_.plane_W->normal_A);
  if (another_pose) return std::nullopt;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    refined.evidence[i] = Ask(SightingIn(object, best.evidence[i].view), model, joint.X_CM[i]);
  }
  if (fusion::Lead(config_.conclude, best, refined) > config_.conclude.min_near_lead) {
    return std::nullopt;
  }
  refined.covariance = InWorld(joint.covariance, refined.X_WM.linear());
  refined.likely_free = LikelyFreeShare(refined);
  return refined;
}

void MultiViewVerification::Refine(ObjectBelief* object) {
  PoseHypothesis& best = object->hypotheses.front();
  if (std::optional<PoseHypothesis> refined = RefinedTogether(*object, best)) {
    best = *std::move(refined);
  }
}

/// Where between `best` turned a little by X_MS and turned back by as much the views' preference is
/// highest: the top of the parabola through the three leads, at most half way. Empty when it is
/// there already, or that is no better.
std::optional<PoseHypothesis> MultiViewVerification::Recentred(const ObjectBelief& object,
                                                               const PoseHypothesis& best,
                                                               const Pose& X_MS) {
  const double angle = RotationDistance(Eigen::Matrix3d::Identity(), X_MS.linear());
  if (angle > 1.01 * kRivalTurn_rad) return std::nullopt;
  const auto lead = [&](const PoseHypothesis& other) {
    return fusion::Lead(config_.conclude, best, other);
  };
  const double ahead = lead(Turned(object, best, X_MS));
  const double behind = lead(Turned(object, best, X_MS.inverse()));
  if (ahead + behind <= 0.0) return std::nullopt;
  const double share = std::clamp(0.5 * (behind - ahead) / (behind + ahead), -0.5, 0.5);
  if (std::abs(share) < kCentred) return std::nullopt;
  PoseHypothesis recentred =
      Turned(object, best, perception::ShareOfTurn(X_MS, ModelOf(best.model).center_M, share));
  if (lead(recentred) > 0.0) return std::nullopt;
  FusePose(&recentred);
  return recentred;
}

void MultiViewVerification::ExamineTurns(ObjectBelief* object) {
  const perception::RecognitionModel& model = ModelOf(object->Best()->model);
  const std::vector<Pose> turns = perception::RivalTurns(model, kRivalTurn_rad);
  for (int round = 0; round < kMaxTurnRounds; ++round) {
    Refine(object);
    PoseHypothesis& best = object->hypotheses.front();
    PoseHypothesis rival;
    Pose X_MS{Pose::Identity()};
    double rival_margin = 0.0;  // how much of the lead it needs `best` lacks over it
    bool better = false;
    for (const Pose& turn : turns) {
      if (perception::LeavesItsRest(model, best.X_WM, turn, belief_.plane_W->normal_A)) continue;
      PoseHypothesis turned = Turned(*object, best, turn);
      const double needed = fusion::NeededLead(config_.conclude, best, turned);
      double lead = fusion::Lead(config_.conclude, best, turned);
      if (lead < needed) lead += ColorLead(model, best, turned, views_);
      const double margin = needed - lead;
      if (margin <= rival_margin) continue;
      rival_margin = margin;
      rival = std::move(turned);
      X_MS = turn;
      better = lead < 0.0;
    }
    if (rival_margin <= 0.0) break;
    FusePose(&rival);
    if (better) {
      best = std::move(rival);
      continue;
    }
    std::optional<PoseHypothesis> recentred = Recentred(*object, best, X_MS);
    if (!recentred || round + 1 == kMaxTurnRounds) {
      object->hypotheses.push_back(std::move(rival));
      break;
    }
    best = *std::move(recentred);
  }
  Conclude(object);
}

/// Where the class is sure and other poses are not, their colours are compared, too. Those that
/// tell are struck for this time: the evidence decides anew whenever there is more of it.
void MultiViewVerification::Conclude(ObjectBelief* object) const {
  const auto conclude = [&] {
    fusion::Conclude(task_, config_.conclude, ClearViews(*object),
                     AppearanceOf(*object, belief_, models_, config_.conclude.view_reliability),
                     object);
  };
  conclude();
  if (object->state != world::ObjectState::kCandidate || object->Best() == nullptr) return;
  const std::string name = object->hypotheses.front().model;
  if (fusion::NormalisedBelief(object->masses, name) < task_.ConfidenceFor(name)) return;
  std::vector<PoseHypothesis> told =
      TakeToldByColors(config_.conclude, ModelOf(name), views_, object);
  if (told.empty()) return;
  conclude();
  for (PoseHypothesis& h : told) {
    h.struck = true;
    object->hypotheses.push_back(std::move(h));
  }
}

void MultiViewVerification::Complete(ObjectBelief* object) {
  for (PoseHypothesis& h : object->hypotheses) {
    if (h.struck) continue;
    const perception::RecognitionModel& model = ModelOf(h.model);
    for (const world::Sighting& sighting : object->sightings) {
      const bool asked = std::any_of(h.evidence.begin(), h.evidence.end(),
                                     [&](const auto& e) { return e.view == sighting.view; });
      if (asked) continue;
      h.evidence.push_back(Ask(sighting, model, RefinedIn(sighting, model, h.X_WM)));
    }
    std::sort(h.evidence.begin(), h.evidence.end(),
              [](const auto& a, const auto& b) { return a.view < b.view; });
    FusePose(&h);
  }
  DropConverged(object);
  DropLeaning(object);
}

/// Drops hypotheses that the views' refinements have brought to where a better one is.
void MultiViewVerification::DropConverged(ObjectBelief* object) const {
  std::vector<PoseHypothesis> kept;
  for (PoseHypothesis& h : object->hypotheses) {
    const perception::RecognitionModel& model = ModelOf(h.model);
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const PoseHypothesis& other) {
      if (other.struck || h.struck || other.model != h.model) return false;
      const perception::PoseDistance d = perception::DistanceUpToSymmetry(
          other.X_WM, h.X_WM, model.symmetry, model.center_M, true);
      return d.translation < kOnePose_m && d.rotation < kOnePose_rad;
    });
    if (same == kept.end()) {
      kept.push_back(std::move(h));
    } else if (fusion::Lead(config_.conclude, h, *same) > 0.0) {
      *same = std::move(h);
    }
  }
  object->hypotheses = std::move(kept);
}

/// Drops poses in which a thing would have to be held where the views cannot tell them from one in
/// which it rests.
void MultiViewVerification::DropLeaning(ObjectBelief* object) const {
  const auto rests = [&](const PoseHypothesis& h) {
    return perception::IsAtRest(ModelOf(h.model), h.X_WM, belief_.plane_W->normal_A);
  };
  std::vector<PoseHypothesis> resting;
  for (const PoseHypothesis& h : object->hypotheses) {
    if (!h.struck && rests(h)) resting.push_back(h);
  }
  std::erase_if(object->hypotheses, [&](const PoseHypothesis& h) {
    return !h.struck && !rests(h) &&
           std::any_of(resting.begin(), resting.end(), [&](const PoseHypothesis& other) {
             return other.model == h.model &&
                    fusion::Lead(config_.conclude, h, other) < config_.conclude.min_lead;
           });
  });
}

/// The pose over all views: each counts by how well and how much of the model it shows.
void MultiViewVerification::FusePose(PoseHypothesis* h) const {
  std::vector<fusion::PoseEstimate> estimates;
  for (const world::ViewEvidence& e : h->evidence) {
    const double weight =
        std::max(1e-3, e.hypothesis.score * e.hypothesis.verification.visible_fraction);
    fusion::PoseEstimate estimate;
    estimate.X_WM = belief_.views[e.view].X_WC * e.hypothesis.X_CM;
    estimate.information.topLeftCorner<3, 3>() *= weight / (kViewSigma_rad * kViewSigma_rad);
    estimate.information.bottomRightCorner<3, 3>() *= weight / (kViewSigma_m * kViewSigma_m);
    estimates.push_back(estimate);
  }
  const fusion::FusedPose fused = fusion::FusePoses(estimates);
  h->X_WM = fused.X_WM;
  h->covariance = fused.covariance;
  h->likely_free = LikelyFreeShare(*h);
}

/// The share of the model's surface that lies where the map is likely free.
double MultiViewVerification::LikelyFreeShare(const PoseHypothesis& h) const {
  const std::vector<perception::ModelPoint>& points = ModelOf(h.model).points;
  std::vector<Vector3d> points_W;
  for (std::size_t i = 0; i < std::min(points.size(), kMapPoints); ++i) {
    points_W.push_back(h.X_WM * points[i].point.cast<double>());
  }
  return space_.LikelyFreeShare(points_W);
}

/// How many sides of the object were seen clearly.
int MultiViewVerification::ClearViews(const ObjectBelief& object) const {
  const Vector3d center_W = object.extent_W.center();
  std::vector<Vector3d> directions;
  for (const world::Sighting& sighting : object.sightings) {
    const world::Observation& observation = belief_.views[sighting.view];
    const world::Cluster& cluster = observation.detections[sighting.detection].cluster;
    if (cluster.touches_border) continue;
    if (static_cast<int>(cluster.pixels.size()) < config_.clear_view_points) continue;
    const Vector3d direction = (observation.X_WC.translation() - center_W).normalized();
    const bool new_side = std::none_of(
        directions.begin(), directions.end(),
        [&](const Vector3d& other) { return direction.dot(other) > std::cos(kSameSide_rad); });
    if (new_side) directions.push_back(direction);
  }
  return static_cast<int>(directions.size());
}

const perception::RecognitionModel& MultiViewVerification::ModelOf(const std::string& name) const {
  return *perception::FindModel(models_, name);
}

}  // namespace secondlook::apps
