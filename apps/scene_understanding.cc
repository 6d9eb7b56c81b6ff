#include "apps/scene_understanding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "apps/appearance.h"
#include "apps/register_capture.h"
#include "lib/geometry/point_image.h"
#include "lib/perception/regroup.h"
#include "lib/perception/seen_through.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using world::ObjectBelief;
using world::ObjectState;
using world::PoseHypothesis;

/// A thing is gone when of at least so many points seen of it, a view sees through this share.
constexpr int kGonePoints = 40;
constexpr double kGoneShare = 0.5;

/// Puts what shows one of `objects` behind what is open, as if it were explained.
void LeaveUnrecognised(const std::set<int>& objects, Associated* things) {
  Associated sorted;
  for (const bool asked : {true, false}) {
    for (std::size_t i = 0; i < things->clusters.size(); ++i) {
      const bool open = i < static_cast<std::size_t>(things->open);
      if (asked != (open && !objects.contains(things->objects[i]))) continue;
      sorted.clusters.push_back(std::move(things->clusters[i]));
      sorted.objects.push_back(things->objects[i]);
    }
    if (asked) sorted.open = static_cast<int>(sorted.clusters.size());
  }
  *things = std::move(sorted);
}

}  // namespace

SceneUnderstanding::SceneUnderstanding(const UnderstandingConfig& config, const world::Task& task,
                                       const world::ObjectDatabase& database)
    : config_(config), task_(task), models_(perception::TrainModels(database)), map_(config) {}

void SceneUnderstanding::InsertModel(const world::ObjectModel& model) {
  const auto place =
      std::find_if(models_.begin(), models_.end(),
                   [&](const perception::RecognitionModel& m) { return m.name > model.name; });
  models_.insert(place, perception::TrainModel(model));
}

void SceneUnderstanding::Learn(const world::ObjectModel& model) {
  InsertModel(model);
  for (ObjectBelief& object : belief_.objects) {
    if (object.state != ObjectState::kUnknown) continue;
    object.state = ObjectState::kCandidate;
    object.reason = fmt::format("may be '{}', which is known since", model.name);
  }
}

void SceneUnderstanding::LearnModelled(int id, const world::ObjectModel& model, const Pose& X_WM) {
  InsertModel(model);
  ObjectBelief& object = belief_.objects[id];
  PoseHypothesis hypothesis;
  hypothesis.model = model.name;
  hypothesis.X_WM = X_WM;
  object.hypotheses.push_back(std::move(hypothesis));
  Verification().Complete(&object);
  Conclude(&object);
  if (config_.known_in_map) map_.PlaceVerified(belief_.objects, models_);
}

void SceneUnderstanding::Note(int id, const std::string& text) {
  ObjectBelief& object = belief_.objects[id];
  object.history += (object.history.empty() ? "" : "; ") + text;
  object.reason += "; " + text;
}

std::string SceneUnderstanding::Add(const Capture& capture) {
  const hal::RgbdFrame& frame = capture.frame;
  const geometry::PointImage cloud = geometry::Deproject(frame.depth, capture.camera);
  const Vector3d up_C = capture.X_WC.linear().transpose() * Vector3d::UnitZ();
  const double max_drop = capture.X_WC.translation().z() - config_.floor_clearance_m;
  perception::Segmentation cut = perception::Segment(cloud, up_C, config_.segment, max_drop);
  if (!cut.plane_C) return cut.reason;
  if (belief_.plane_W) perception::PutFirst(*belief_.plane_W, capture.X_WC, &cut);

  const std::vector<perception::SurfacePoint> points_C =
      perception::ViewPoints(frame.depth, capture.camera, *cut.plane_C, config_.registration);
  const perception::ViewRegistration registration =
      RegisterCapture(capture, cut, points_C, belief_.plane_W, map_, models_, config_);
  if (!registration.accepted) return registration.reason;
  const Pose& X_WC = registration.X_WC;
  const std::vector<int> gone = Gone(capture, X_WC);
  if (std::string reason = Contradiction(capture, X_WC, gone); !reason.empty()) return reason;

  const int view = static_cast<int>(belief_.views.size());
  for (const int id : gone) Unlearn(view, &belief_.objects[id]);
  Associated things =
      Association().Associate(std::move(cut.clusters), frame.depth, capture.camera, registration);
  std::vector<world::Detection> detections =
      Recognise(perception::MakeView(frame.color, frame.depth, capture.camera, *cut.plane_C, {},
                                     cut.FurtherPlanes()),
                X_WC, &things);
  views_.push_back(perception::MakeView(frame.color, frame.depth, capture.camera, *cut.plane_C,
                                        things.clusters, cut.FurtherPlanes()));
  belief_.views.push_back({frame, capture.camera, X_WC, *cut.plane_C, std::move(detections)});
  planes_.Grow(cut, X_WC, &belief_);
  covariance_ = registration.covariance;
  map_.Enter(points_C, registration, belief_.views, *belief_.plane_W);
  for (int i = 0; i < static_cast<int>(things.objects.size()); ++i) {
    ObjectBelief& object = belief_.objects[things.objects[i]];
    Association().AddSighting(view, i, &object);
    MultiViewVerification verification = Verification();
    verification.AddFresh(view, belief_.views.back().detections[i], &object);
    verification.Complete(&object);
    Conclude(&object);
  }
  MergeDuplicates();
  FollowMoved();
  if (config_.known_in_map) map_.PlaceVerified(belief_.objects, models_);
  return "";
}

/// Makes one of two objects that turn out to be the same thing.
void SceneUnderstanding::MergeDuplicates() {
  for (ObjectBelief& a : belief_.objects) {
    for (ObjectBelief& b : belief_.objects) {
      if (b.id <= a.id || a.state == ObjectState::kRejected || b.state == ObjectState::kRejected) {
        continue;
      }
      if (!Association().AreOne(a, b)) continue;
      Association().Merge({a.id, b.id});
      Verification().Complete(&a);
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
  map_.Forget(view, *object);
  if (object->state == ObjectState::kVerified) {
    const PoseHypothesis& best = *object->Best();
    gone_.push_back({object->id, view, best.model, best.X_WM * ModelOf(best.model).center_M});
  }
  object->state = ObjectState::kRejected;
  object->reason = fmt::format("is gone from its place: view {} sees through it", view);
}

/// A thing that is verified, where nothing like it was before, may be one that is gone from its
/// place: the nearest of its model within reach. It is that object then, moved; the others stay
/// gone.
void SceneUnderstanding::FollowMoved() {
  for (ObjectBelief& found : belief_.objects) {
    if (found.state != ObjectState::kVerified) continue;
    const PoseHypothesis& best = *found.Best();
    const Vector3d center_W = best.X_WM * ModelOf(best.model).center_M;
    const auto distance = [&](const GoneThing& gone) {
      const bool may_be = gone.model == best.model && gone.view <= found.sightings.front().view;
      return may_be ? (gone.center_W - center_W).norm() : std::numeric_limits<double>::infinity();
    };
    const auto nearest = std::min_element(
        gone_.begin(), gone_.end(),
        [&](const GoneThing& a, const GoneThing& b) { return distance(a) < distance(b); });
    if (nearest == gone_.end() || std::isinf(distance(*nearest))) continue;
    const double moved = distance(*nearest);
    if (moved > config_.moved_within_m) {
      const std::string why = fmt::format(
          "; is new: the '{}' that is gone stood {:.2f} m away (moved is what reappears within "
          "{:.2f})",
          best.model, moved, config_.moved_within_m);
      if (found.reason.find("; is new") == std::string::npos) found.reason += why;
      continue;
    }
    ObjectBelief& same = belief_.objects[nearest->id];
    const int old_id = found.id;
    const int looks_taken = same.looks_taken + found.looks_taken;
    same = std::move(found);
    same.id = nearest->id;
    same.looks_taken = looks_taken;
    same.history = fmt::format("was moved by {:.2f} m before view {}", moved, nearest->view);
    same.reason += "; " + same.history;
    map_.Rename(old_id, same.id);
    found = {};
    found.id = old_id;
    found.state = ObjectState::kRejected;
    found.reason = fmt::format("is object {}, moved", same.id);
    gone_.erase(nearest);
  }
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

/// The detections of the newest view, taken from X_WC: recognition may cut or join what is open,
/// and with it the objects. What is verified is not recognised anew, only asked whether it still
/// holds (MultiViewVerification::Complete()).
std::vector<world::Detection> SceneUnderstanding::Recognise(const perception::View& view,
                                                            const Pose& X_WC, Associated* things) {
  if (!not_recognised_.empty()) LeaveUnrecognised(not_recognised_, things);
  const auto first_explained = things->clusters.begin() + things->open;
  const std::vector<world::Cluster> open(things->clusters.begin(), first_explained);
  perception::Regrouped found = perception::RecogniseRegrouping(
      perception::MakeView(view.color, view.depth, view.camera, view.plane_C, open, view.further_C),
      open, models_, config_.recognise);
  std::vector<int> objects = Association().AfterRegrouping(found, X_WC, things->objects);
  for (std::size_t i = open.size(); i < things->clusters.size(); ++i) {
    found.detections.push_back({things->clusters[i], {}, "", {}});
    objects.push_back(things->objects[i]);
  }
  things->objects = std::move(objects);
  things->clusters.clear();
  for (world::Detection& detection : found.detections) {
    things->clusters.push_back(detection.cluster);
    if (classifier_ == nullptr) continue;
    detection.appearance = LooksOf(detection.cluster, view.color, *classifier_);
  }
  return std::move(found.detections);
}

/// Concludes what the object is; views are registered to the whole model of what is verified.
void SceneUnderstanding::Conclude(ObjectBelief* object) {
  Verification().Conclude(object);
  const bool stands_already = object->state == ObjectState::kVerified && map_.HasModel(object->id);
  if (object->state == ObjectState::kVerified && !stands_already) {
    Verification().ExamineTurns(object);
  }
  if (!object->history.empty()) object->reason += "; " + object->history;
  if (stands_already) {
    Verification().Refine(object);
    return;
  }
  map_.RemoveModel(object->id);
  if (object->state != ObjectState::kVerified) return;
  const PoseHypothesis& best = *object->Best();
  map_.AddModel(object->id, ModelOf(best.model), best.X_WM);
}

MultiViewVerification SceneUnderstanding::Verification() const {
  return {config_, task_, models_, belief_, views_, map_.space()};
}

DataAssociation SceneUnderstanding::Association() {
  return {config_, models_, &belief_, &views_, &map_};
}

const perception::RecognitionModel& SceneUnderstanding::ModelOf(const std::string& name) const {
  return *perception::FindModel(models_, name);
}

}  // namespace secondlook::apps
