#include "apps/scene_understanding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "lib/fusion/match.h"
#include "lib/fusion/pose_fusion.h"
#include "lib/geometry/point_image.h"
#include "lib/perception/explain.h"
#include "lib/perception/refine.h"
#include "lib/perception/rival_turns.h"
#include "lib/perception/seen_through.h"
#include "lib/perception/turn_by_color.h"
#include "lib/perception/verify.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using world::ObjectBelief;
using world::ObjectState;
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
/// How well the surface of a verified model is known in the map.
constexpr double kModelSigma_m = 0.003;
/// Directions nearer than this show the same side of a thing.
constexpr double kSameSide_rad = 0.5;
constexpr double kPointSpacing_m = 0.005;
/// A thing is gone when of at least so many points seen of it, a view sees through this share.
constexpr int kGonePoints = 40;
constexpr double kGoneShare = 0.5;
/// So many points of a model are looked up in the map.
constexpr std::size_t kMapPoints = 500;

std::vector<Vector3d> InWorld(const Pose& X_WC, const std::vector<Vector3d>& points_C) {
  std::vector<Vector3d> points_W;
  points_W.reserve(points_C.size());
  for (const Vector3d& p : points_C) points_W.push_back(X_WC * p);
  return points_W;
}

/// `points` and `more`, with one point kept for each cell of a grid of `spacing`; the first stays.
std::vector<Vector3d> Thinned(std::vector<Vector3d> points, const std::vector<Vector3d>& more,
                              double spacing) {
  points.insert(points.end(), more.begin(), more.end());
  std::vector<std::pair<std::array<int, 3>, int>> cells;
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    const Eigen::Vector3i c = (points[i] / spacing).array().floor().cast<int>();
    cells.push_back({{c.x(), c.y(), c.z()}, i});
  }
  std::sort(cells.begin(), cells.end());
  std::vector<int> kept;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].first != cells[i - 1].first) kept.push_back(cells[i].second);
  }
  std::sort(kept.begin(), kept.end());
  std::vector<Vector3d> thinned;
  for (const int i : kept) thinned.push_back(points[i]);
  return thinned;
}

std::vector<int> UnionOfPixels(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> all = a;
  all.insert(all.end(), b.begin(), b.end());
  return all;
}

/// The box in W around the model at X_WM.
Eigen::AlignedBox3d BoxOf(const perception::RecognitionModel& model, const Pose& X_WM) {
  Eigen::AlignedBox3d box_W;
  for (const Eigen::Vector3f& p_M : model.hull) box_W.extend(X_WM * p_M.cast<double>());
  return box_W;
}

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

}  // namespace

SceneUnderstanding::SceneUnderstanding(const UnderstandingConfig& config, const world::Task& task,
                                       const world::ObjectDatabase& database)
    : config_(config),
      task_(task),
      models_(perception::TrainModels(database)),
      space_(config.voxel_space) {}

void SceneUnderstanding::Learn(const world::ObjectModel& model) {
  const auto place =
      std::find_if(models_.begin(), models_.end(),
                   [&](const perception::RecognitionModel& m) { return m.name > model.name; });
  models_.insert(place, perception::TrainModel(model));
  for (ObjectBelief& object : belief_.objects) {
    if (object.state != ObjectState::kUnknown) continue;
    object.state = ObjectState::kCandidate;
    object.reason = fmt::format("may be '{}', which is known since", model.name);
  }
}

std::string SceneUnderstanding::Add(const Capture& capture) {
  const hal::RgbdFrame& frame = capture.frame;
  const geometry::PointImage cloud = geometry::Deproject(frame.depth, capture.camera);
  const Vector3d up_C = capture.X_WC.linear().transpose() * Vector3d::UnitZ();
  const double max_drop = capture.X_WC.translation().z() - config_.floor_clearance_m;
  perception::Segmentation cut = perception::Segment(cloud, up_C, config_.segment, max_drop);
  if (!cut.plane_C) return cut.reason;

  const std::vector<perception::SurfacePoint> points_C =
      perception::ViewPoints(frame.depth, capture.camera, *cut.plane_C, config_.registration);
  const perception::ViewRegistration registration = Register(points_C, capture);
  if (!registration.accepted) return registration.reason;
  const Pose& X_WC = registration.X_WC;
  const std::vector<int> gone = Gone(capture, X_WC);
  if (std::string reason = Contradiction(capture, X_WC, gone); !reason.empty()) return reason;

  const int view = static_cast<int>(belief_.views.size());
  for (const int id : gone) Unlearn(view, &belief_.objects[id]);
  Matched matched = MatchClusters(std::move(cut.clusters), frame.depth, capture.camera, X_WC);
  views_.push_back(perception::MakeView(frame.color, frame.depth, capture.camera, *cut.plane_C,
                                        matched.clusters));
  belief_.views.push_back({frame, capture.camera, X_WC, *cut.plane_C, Recognise(matched)});
  GrowPlane(cut.plane_points_C, *cut.plane_C, X_WC);
  reference_.AddView(points_C, X_WC, registration.covariance);
  EnterNewestView();
  for (int i = 0; i < static_cast<int>(matched.objects.size()); ++i) {
    ObjectBelief& object = belief_.objects[matched.objects[i]];
    AddSighting(view, i, &object);
    AddFreshHypotheses(view, belief_.views.back().detections[i], &object);
    CompleteEvidence(&object);
    Conclude(&object);
  }
  MergeDuplicates();
  PlaceVerified();
  return "";
}

/// Two objects that are believed to be one model at one place are its two ends: something in front
/// cut it in two, and each end was recognised by itself.
void SceneUnderstanding::MergeDuplicates() {
  const auto standing = [](const ObjectBelief& object) {
    return object.state != ObjectState::kRejected && object.Best() != nullptr &&
           object.Best()->support > 0.5;
  };
  for (ObjectBelief& a : belief_.objects) {
    for (ObjectBelief& b : belief_.objects) {
      if (b.id <= a.id || !standing(a) || !standing(b)) continue;
      const PoseHypothesis& one = *a.Best();
      const PoseHypothesis& other = *b.Best();
      if (one.model != other.model) continue;
      const perception::RecognitionModel& model = ModelOf(one.model);
      const double distance = (one.X_WM * model.center_M - other.X_WM * model.center_M).norm();
      if (distance > kSamePose_m) continue;
      MergedObject({a.id, b.id});
      CompleteEvidence(&a);
      Conclude(&a);
    }
  }
}

/// The ids of the objects that stood where a view from X_WC sees through them: they were taken away
/// or moved. When that is so of several, and of more than stand as they were, it is the view that
/// is wrong, and there are none.
std::vector<int> SceneUnderstanding::Gone(const Capture& capture, const Pose& X_WC) const {
  std::vector<int> gone;
  std::size_t there = 0;
  for (const ObjectBelief& object : belief_.objects) {
    if (object.state == ObjectState::kRejected) continue;
    const perception::SurfaceAgreement agreement =
        perception::ComparePoints(object.points_W, X_WC, capture.frame.depth, capture.camera);
    const int seen = agreement.matching + agreement.see_through;
    if (seen < kGonePoints) continue;
    if (agreement.see_through > kGoneShare * seen) {
      gone.push_back(object.id);
    } else {
      ++there;
    }
  }
  if (gone.size() > 1 && gone.size() > there) gone.clear();
  return gone;
}

/// Forgets what was known of the place of an object that is gone since `view`. Where it is now, it
/// is another object.
void SceneUnderstanding::Unlearn(int view, ObjectBelief* object) {
  Eigen::AlignedBox3d box_W = object->extent_W;
  const auto modelled = modelled_W_.find(object->id);
  if (modelled != modelled_W_.end()) box_W.extend(modelled->second);
  box_W =
      Eigen::AlignedBox3d(box_W.min().array() - kModelSigma_m, box_W.max().array() + kModelSigma_m);
  TakeOutOfReference(object->id);
  reference_.Remove(box_W);
  space_.TakeAway(object->id);
  space_.RemoveRegion(box_W);
  unlearned_.push_back({view, box_W});
  object->state = ObjectState::kRejected;
  object->reason = fmt::format("is gone from its place: view {} sees through it", view);
}

/// Why the view cannot have been taken from X_WC: it would see through what is verified and not
/// `gone`. Empty when it could.
std::string SceneUnderstanding::Contradiction(const Capture& capture, const Pose& X_WC,
                                              const std::vector<int>& gone) const {
  perception::SurfaceAgreement sum;
  for (const ObjectBelief& object : belief_.objects) {
    if (object.state != ObjectState::kVerified) continue;
    if (std::binary_search(gone.begin(), gone.end(), object.id)) continue;
    const PoseHypothesis& known = *object.Best();
    const perception::SurfaceAgreement agreement =
        perception::CompareSurface(ModelOf(known.model).mesh, X_WC.inverse() * known.X_WM,
                                   capture.frame.depth, capture.camera);
    sum.matching += agreement.matching;
    sum.see_through += agreement.see_through;
  }
  if (sum.see_through <= config_.max_see_through * (sum.matching + sum.see_through)) return "";
  return fmt::format("registered, it sees through verified objects at {} pixels and agrees at {}",
                     sum.see_through, sum.matching);
}

/// The first view defines the map; the others are registered to it.
perception::ViewRegistration SceneUnderstanding::Register(
    const std::vector<perception::SurfacePoint>& points_C, const Capture& capture) const {
  if (reference_.empty()) {
    perception::ViewRegistration first;
    first.X_WC = capture.X_WC;
    first.accepted = true;
    return first;
  }
  const perception::PoseCovariance covariance =
      perception::NominalCovariance(config_.registration, capture.p_CB_W);
  return perception::RegisterView(points_C, reference_, capture.X_WC, covariance,
                                  config_.registration);
}

void SceneUnderstanding::GrowPlane(const std::vector<Vector3d>& plane_points_C,
                                   const world::SupportPlane& plane_C, const Pose& X_WC) {
  if (!belief_.plane_W) belief_.plane_W = world::Transform(X_WC, plane_C);
  plane_points_W_ = Thinned(std::move(plane_points_W_), InWorld(X_WC, plane_points_C), 0.02);
  belief_.plane_W->corners_A =
      perception::FitRectangle(plane_points_W_, belief_.plane_W->normal_A, belief_.plane_W->offset);
  belief_.plane_W->inliers = static_cast<int>(plane_points_W_.size());
}

SceneUnderstanding::Matched SceneUnderstanding::MatchClusters(std::vector<world::Cluster> clusters,
                                                              const cv::Mat& depth,
                                                              const hal::CameraModel& camera,
                                                              const Pose& X_WC) {
  Matched matched;
  std::vector<world::Cluster> explained;
  std::vector<int> explained_by;  // ids
  std::vector<int> open;          // ids of the objects that the other clusters are matched with
  for (const ObjectBelief& object : belief_.objects) {
    if (object.state == ObjectState::kRejected) continue;
    if (object.state != ObjectState::kVerified) {
      open.push_back(object.id);
      continue;
    }
    // What is known stands there as its whole model, and takes what that explains.
    const PoseHypothesis& known = *object.Best();
    world::Cluster cluster =
        perception::TakeExplained(ModelOf(known.model).mesh, X_WC.inverse() * known.X_WM, depth,
                                  camera, config_.min_leftover_points, &clusters);
    if (static_cast<int>(cluster.pixels.size()) < config_.segment.min_cluster_points) continue;
    explained.push_back(std::move(cluster));
    explained_by.push_back(object.id);
  }

  std::vector<fusion::Footprint> detections;
  for (const world::Cluster& cluster : clusters) {
    detections.emplace_back(InWorld(X_WC, cluster.points_C), config_.footprint_cell_m);
  }
  std::vector<fusion::Footprint> objects;
  for (const int id : open) {
    objects.emplace_back(belief_.objects[id].points_W, config_.footprint_cell_m);
  }
  for (const fusion::Match& match :
       fusion::MatchByFootprint(detections, objects, config_.footprint_overlap)) {
    if (match.detections.empty()) continue;  // not seen this time
    std::vector<int> pixels;
    for (const int d : match.detections) pixels = UnionOfPixels(pixels, clusters[d].pixels);
    std::vector<int> ids;
    for (const int o : match.objects) ids.push_back(open[o]);
    matched.clusters.push_back(perception::MakeCluster(std::move(pixels), depth, camera));
    matched.objects.push_back(MergedObject(ids));
  }
  matched.open = static_cast<int>(matched.clusters.size());
  std::move(explained.begin(), explained.end(), std::back_inserter(matched.clusters));
  matched.objects.insert(matched.objects.end(), explained_by.begin(), explained_by.end());
  return matched;
}

/// The detections of the newest view: what is verified is not recognised anew, only asked whether
/// it still holds (CompleteEvidence).
std::vector<world::Detection> SceneUnderstanding::Recognise(const Matched& matched) const {
  const auto first_explained = matched.clusters.begin() + matched.open;
  std::vector<world::Detection> detections = perception::Recognise(
      views_.back(), {matched.clusters.begin(), first_explained}, models_, config_.recognise);
  for (auto cluster = first_explained; cluster != matched.clusters.end(); ++cluster) {
    detections.push_back({*cluster, {}, ""});
  }
  return detections;
}

/// The object that all of `ids` are; a new one when there are none.
int SceneUnderstanding::MergedObject(const std::vector<int>& ids) {
  if (ids.empty()) {
    belief_.objects.emplace_back();
    belief_.objects.back().id = static_cast<int>(belief_.objects.size()) - 1;
    return belief_.objects.back().id;
  }
  ObjectBelief& whole = belief_.objects[ids.front()];
  for (const int id : ids) {
    if (ids.size() > 1) TakeOutOfReference(id);  // which of them is right is concluded anew
  }
  for (std::size_t i = 1; i < ids.size(); ++i) {
    ObjectBelief& part = belief_.objects[ids[i]];
    for (const world::Sighting& sighting : part.sightings) {
      const auto same_view =
          std::find_if(whole.sightings.begin(), whole.sightings.end(),
                       [&](const world::Sighting& s) { return s.view == sighting.view; });
      if (same_view == whole.sightings.end()) {
        whole.sightings.push_back(sighting);
        continue;
      }
      // Two pieces in one view: one cluster from now on, and what was said of the pieces is void.
      perception::View& view = views_[sighting.view];
      world::Observation& observation = belief_.views[sighting.view];
      world::Cluster& piece = observation.detections[sighting.detection].cluster;
      world::Cluster& kept = observation.detections[same_view->detection].cluster;
      for (const int pixel : piece.pixels) {
        view.labels.at<int>(pixel / view.camera.width, pixel % view.camera.width) =
            same_view->detection;
      }
      kept = perception::MakeCluster(UnionOfPixels(kept.pixels, piece.pixels),
                                     observation.frame.depth, observation.camera);
      piece = {};
      for (PoseHypothesis& h : whole.hypotheses) {
        std::erase_if(h.evidence, [&](const auto& e) { return e.view == sighting.view; });
      }
    }
    std::sort(whole.sightings.begin(), whole.sightings.end(),
              [](const auto& a, const auto& b) { return a.view < b.view; });
    whole.points_W = Thinned(std::move(whole.points_W), part.points_W, kPointSpacing_m);
    std::erase_if(whole.hypotheses, [](const auto& h) { return h.evidence.empty(); });
    whole.looks_taken += part.looks_taken;
    const int id = part.id;
    part = {};
    part.id = id;
    part.state = ObjectState::kRejected;
    part.reason = fmt::format("is a part of object {}", whole.id);
  }
  return whole.id;
}

void SceneUnderstanding::AddSighting(int view, int detection, ObjectBelief* object) {
  const world::Observation& observation = belief_.views[view];
  object->sightings.push_back({view, detection});
  object->points_W =
      Thinned(std::move(object->points_W),
              InWorld(observation.X_WC, observation.detections[detection].cluster.points_C),
              kPointSpacing_m);
  object->extent_W.setEmpty();
  for (const Vector3d& p : object->points_W) object->extent_W.extend(p);
}

void SceneUnderstanding::AddFreshHypotheses(int view, const world::Detection& detection,
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
Pose SceneUnderstanding::RefinedIn(const world::Sighting& sighting,
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
world::ViewEvidence SceneUnderstanding::Ask(const world::Sighting& sighting,
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
PoseHypothesis SceneUnderstanding::Turned(const ObjectBelief& object, const PoseHypothesis& best,
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
std::optional<PoseHypothesis> SceneUnderstanding::RefinedTogether(const ObjectBelief& object,
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

/// Where between `best` turned a little by X_MS and turned back by as much the views' preference is
/// highest: the top of the parabola through the three leads, at most half way. Empty when it is
/// there already, or that is no better.
std::optional<PoseHypothesis> SceneUnderstanding::Recentred(const ObjectBelief& object,
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

/// Is the pose of a verified object held by what was seen? Turned a little, or to where its shape
/// is the same, it must fit worse in the views together. A turn that fits better takes its place,
/// one that fits nearly as well moves it to where it is as far ahead on either side; what then
/// still fits nearly as well is a hypothesis of its own, and the object is open again.
void SceneUnderstanding::ExamineTurns(ObjectBelief* object) {
  const perception::RecognitionModel& model = ModelOf(object->Best()->model);
  const std::vector<Pose> turns = perception::RivalTurns(model, kRivalTurn_rad);
  for (int round = 0; round < kMaxTurnRounds; ++round) {
    PoseHypothesis& best = object->hypotheses.front();
    if (std::optional<PoseHypothesis> refined = RefinedTogether(*object, best)) {
      best = *std::move(refined);
    }
    PoseHypothesis rival;
    Pose X_MS{Pose::Identity()};
    double rival_margin = 0.0;  // how much of the lead it needs `best` lacks over it
    bool better = false;
    for (const Pose& turn : turns) {
      if (perception::LeavesItsRest(model, best.X_WM, turn, belief_.plane_W->normal_A)) continue;
      PoseHypothesis turned = Turned(*object, best, turn);
      const double lead = fusion::Lead(config_.conclude, best, turned);
      const double margin = fusion::NeededLead(config_.conclude, best, turned) - lead;
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
  fusion::Conclude(task_, config_.conclude, ClearViews(*object), object);
}

/// Asks every view that shows the object about every hypothesis that it was not asked about
/// yet.
void SceneUnderstanding::CompleteEvidence(ObjectBelief* object) {
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
void SceneUnderstanding::DropConverged(ObjectBelief* object) const {
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
void SceneUnderstanding::DropLeaning(ObjectBelief* object) const {
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
void SceneUnderstanding::FusePose(PoseHypothesis* h) const {
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
double SceneUnderstanding::LikelyFreeShare(const PoseHypothesis& h) const {
  const std::vector<perception::ModelPoint>& points = ModelOf(h.model).points;
  std::vector<Vector3d> points_W;
  for (std::size_t i = 0; i < std::min(points.size(), kMapPoints); ++i) {
    points_W.push_back(h.X_WM * points[i].point.cast<double>());
  }
  return space_.LikelyFreeShare(points_W);
}

/// How many sides of the object were seen clearly.
int SceneUnderstanding::ClearViews(const ObjectBelief& object) const {
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

void SceneUnderstanding::Conclude(ObjectBelief* object) {
  fusion::Conclude(task_, config_.conclude, ClearViews(*object), object);
  if (object->state == ObjectState::kVerified && modelled_W_.contains(object->id)) {
    PoseHypothesis& best = object->hypotheses.front();
    if (auto refined = RefinedTogether(*object, best)) best = *std::move(refined);
    return;
  }
  if (object->state == ObjectState::kVerified) ExamineTurns(object);
  TakeOutOfReference(object->id);
  if (object->state != ObjectState::kVerified) return;
  const PoseHypothesis& best = *object->Best();
  const perception::RecognitionModel& model = ModelOf(best.model);
  reference_.AddModel(model.mesh, best.X_WM, kModelSigma_m);
  modelled_W_[object->id] = BoxOf(model, best.X_WM);
}

/// Views are no longer registered to the whole model of an object, if they were.
void SceneUnderstanding::TakeOutOfReference(int id) {
  const auto modelled = modelled_W_.find(id);
  if (modelled == modelled_W_.end()) return;
  reference_.Remove(modelled->second);
  modelled_W_.erase(modelled);
}

/// Enters the newest view into the map.
void SceneUnderstanding::EnterNewestView() {
  const auto insert = [&](const world::Observation& view) {
    space_.Insert(view.frame.depth, view.camera, view.X_WC, config_.depth_stride);
  };
  const auto& corners_W = belief_.plane_W->corners_A;
  const world::BrickGrid* workspace = space_.workspace();
  const bool covered = workspace != nullptr &&
                       std::all_of(corners_W.begin(), corners_W.end(),
                                   [&](const Vector3d& p) { return workspace->Contains(p); });
  if (covered) {
    insert(belief_.views.back());
    return;
  }
  // The table turned out to be larger: all over again, with room for more.
  space_ = world::VoxelSpace(config_.voxel_space,
                             world::WorkspaceAbove(*belief_.plane_W, config_.voxel_space));
  for (int view = 0; view < static_cast<int>(belief_.views.size()); ++view) {
    for (const Unlearned& unlearned : unlearned_) {
      if (unlearned.view == view) space_.RemoveRegion(unlearned.box_W);
    }
    insert(belief_.views[view]);
  }
}

/// Lets what is verified, and nothing else, stand in the map as its whole model.
void SceneUnderstanding::PlaceVerified() {
  for (const ObjectBelief& object : belief_.objects) {
    if (object.state == ObjectState::kVerified) {
      const PoseHypothesis& best = *object.Best();
      space_.Place(object.id, ModelOf(best.model).mesh, best.X_WM);
    } else {
      space_.TakeAway(object.id);
    }
  }
}

const perception::RecognitionModel& SceneUnderstanding::ModelOf(const std::string& name) const {
  return *perception::FindModel(models_, name);
}

}  // namespace secondlook::apps
