#include "apps/scene_understanding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <Eigen/Eigenvalues>

#include "lib/fusion/match.h"
#include "lib/geometry/kd_tree.h"
#include "lib/geometry/point_image.h"
#include "lib/perception/choose_together.h"
#include "lib/perception/explain.h"
#include "lib/perception/regroup.h"
#include "lib/perception/seen_through.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using world::ObjectBelief;
using world::ObjectState;
using world::PoseHypothesis;

/// Two objects of one model nearer than this are its two ends.
constexpr double kSamePose_m = 0.03;
/// How well the surface of a verified model is known in the map.
constexpr double kModelSigma_m = 0.003;
constexpr double kPointSpacing_m = 0.005;
/// A view that lies in the map no better than this is registered by what it recognises, too …
constexpr double kLoose_m = 0.008;
/// … which a hypothesis tells when it is more likely right than not.
constexpr double kLandmarkScore = 0.5;
/// A thing is gone when of at least so many points seen of it, a view sees through this share.
constexpr int kGonePoints = 40;
constexpr double kGoneShare = 0.5;
/// Planes that differ less in height, and reach so near to one another, are one.
constexpr double kSameLevel_m = 0.03;
constexpr double kPlaneReach_m = 0.1;
/// Of two things that touch, as they were measured, no more of one stands in the other.
constexpr double kMostInside = 0.2;
/// What was seen of a thing is the surface of another where this share of its points is so near.
constexpr double kPartShare = 0.8;
constexpr double kOnSurface_m = 0.015;

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
  if (belief_.plane_W) perception::PutFirst(*belief_.plane_W, capture.X_WC, &cut);

  const std::vector<perception::SurfacePoint> points_C =
      perception::ViewPoints(frame.depth, capture.camera, *cut.plane_C, config_.registration);
  const perception::ViewRegistration registration = Register(points_C, capture, cut);
  if (!registration.accepted) return registration.reason;
  const Pose& X_WC = registration.X_WC;
  const std::vector<int> gone = Gone(capture, X_WC);
  if (std::string reason = Contradiction(capture, X_WC, gone); !reason.empty()) return reason;

  const int view = static_cast<int>(belief_.views.size());
  for (const int id : gone) Unlearn(view, &belief_.objects[id]);
  Matched matched =
      MatchClusters(std::move(cut.clusters), frame.depth, capture.camera, registration);
  std::vector<world::Detection> detections =
      Recognise(perception::MakeView(frame.color, frame.depth, capture.camera, *cut.plane_C, {},
                                     cut.FurtherPlanes()),
                X_WC, &matched);
  views_.push_back(perception::MakeView(frame.color, frame.depth, capture.camera, *cut.plane_C,
                                        matched.clusters, cut.FurtherPlanes()));
  belief_.views.push_back({frame, capture.camera, X_WC, *cut.plane_C, std::move(detections)});
  GrowPlane(cut.plane_points_C, *cut.plane_C, X_WC);
  GrowFurther(cut.further, X_WC);
  reference_.AddView(points_C, X_WC, registration.covariance);
  EnterNewestView();
  for (int i = 0; i < static_cast<int>(matched.objects.size()); ++i) {
    ObjectBelief& object = belief_.objects[matched.objects[i]];
    AddSighting(view, i, &object);
    MultiViewVerification verification = Verification();
    verification.AddFresh(view, belief_.views.back().detections[i], &object);
    verification.Complete(&object);
    Conclude(&object);
  }
  MergeDuplicates();
  FollowMoved();
  PlaceVerified();
  return "";
}

/// True when both are believed to be one model at one place: they are its two ends. Something in
/// front cut it in two, and each end was recognised by itself.
bool SceneUnderstanding::AreOneModel(const ObjectBelief& a, const ObjectBelief& b) const {
  const auto standing = [](const ObjectBelief& object) {
    return object.Best() != nullptr && object.Best()->support > 0.5;
  };
  if (!standing(a) || !standing(b)) return false;
  const PoseHypothesis& one = *a.Best();
  const PoseHypothesis& other = *b.Best();
  if (one.model != other.model) return false;
  const perception::RecognitionModel& model = ModelOf(one.model);
  const double distance = (one.X_WM * model.center_M - other.X_WM * model.center_M).norm();
  return distance <= kSamePose_m;
}

/// True when what was seen of an open object is the surface of a verified one, e.g. its front, seen
/// before its back was recognised: two things cannot stand in one place.
bool SceneUnderstanding::IsPartOf(const ObjectBelief& object, const ObjectBelief& whole) const {
  if (object.Settled() || whole.state != ObjectState::kVerified || object.points_W.empty()) {
    return false;
  }
  const PoseHypothesis& best = *whole.Best();
  const perception::RecognitionModel& model = ModelOf(best.model);
  if (!BoxOf(model, best.X_WM).intersects(object.extent_W)) return false;
  std::vector<Vector3d> points_M;
  for (const perception::ModelPoint& p : model.points) points_M.push_back(p.point.cast<double>());
  const geometry::KdTree surface_M(std::move(points_M));
  const Pose X_MW = best.X_WM.inverse();
  const auto on_it =
      std::count_if(object.points_W.begin(), object.points_W.end(), [&](const Vector3d& p_WQ) {
        return surface_M.Nearest(X_MW * p_WQ, kOnSurface_m).has_value();
      });
  return static_cast<double>(on_it) >= kPartShare * static_cast<double>(object.points_W.size());
}

/// Makes one of two objects that turn out to be the same thing.
void SceneUnderstanding::MergeDuplicates() {
  for (ObjectBelief& a : belief_.objects) {
    for (ObjectBelief& b : belief_.objects) {
      if (b.id <= a.id || a.state == ObjectState::kRejected || b.state == ObjectState::kRejected) {
        continue;
      }
      if (!AreOneModel(a, b) && !IsPartOf(a, b) && !IsPartOf(b, a)) continue;
      MergedObject({a.id, b.id});
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
    if (const auto modelled = modelled_W_.extract(old_id)) modelled_W_[same.id] = modelled.mapped();
    space_.TakeAway(old_id);
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

/// The first view defines the map; the others are registered to it. What a view recognises has
/// sides that it does not see and another view did: one that shares too little with the map is
/// registered by these, too.
perception::ViewRegistration SceneUnderstanding::Register(
    std::vector<perception::SurfacePoint> points_C, const Capture& capture,
    const perception::Segmentation& cut) const {
  if (reference_.empty()) {
    perception::ViewRegistration first;
    first.X_WC = capture.X_WC;
    first.accepted = true;
    return first;
  }
  const perception::PoseCovariance covariance =
      perception::NominalCovariance(config_.registration, capture.p_CB_W);
  const auto register_by = [&](const std::vector<perception::SurfacePoint>& points) {
    return perception::RegisterView(points, reference_, capture.X_WC, covariance,
                                    config_.registration);
  };
  const perception::ViewRegistration by_surface = register_by(points_C);
  if (by_surface.accepted && SpreadOf(by_surface) <= kLoose_m) return by_surface;
  const std::vector<perception::SurfacePoint> hidden_C = HiddenSides(capture, cut);
  if (hidden_C.empty()) return by_surface;
  points_C.insert(points_C.end(), hidden_C.begin(), hidden_C.end());
  const perception::ViewRegistration by_things = register_by(points_C);
  const bool better =
      by_things.accepted && (!by_surface.accepted || SpreadOf(by_things) < SpreadOf(by_surface));
  return better ? by_things : by_surface;
}

/// The surfaces that face away from the camera, of all that a view recognises by itself.
std::vector<perception::SurfacePoint> SceneUnderstanding::HiddenSides(
    const Capture& capture, const perception::Segmentation& cut) const {
  const perception::View view =
      perception::MakeView(capture.frame.color, capture.frame.depth, capture.camera, *cut.plane_C,
                           cut.clusters, cut.FurtherPlanes());
  const perception::Regrouped found =
      perception::RecogniseRegrouping(view, cut.clusters, models_, config_.recognise);
  std::vector<perception::SurfacePoint> hidden_C;
  for (const world::Detection& detection : found.detections) {
    const auto best = std::max_element(
        detection.hypotheses.begin(), detection.hypotheses.end(),
        [](const world::Hypothesis& a, const world::Hypothesis& b) { return a.score < b.score; });
    if (best == detection.hypotheses.end() || best->score < kLandmarkScore) continue;
    for (const perception::ModelPoint& p : ModelOf(best->model).points) {
      const Vector3d p_CP = best->X_CM * p.point.cast<double>();
      const Vector3d normal_C = best->X_CM.linear() * p.normal.cast<double>();
      if (normal_C.dot(p_CP) > 0.0) hidden_C.push_back({p_CP, normal_C, kModelSigma_m});
    }
  }
  return hidden_C;
}

/// How far off a view's points may lie in the map, in the worst direction [m].
double SceneUnderstanding::SpreadOf(const perception::ViewRegistration& registration) const {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(ErrorOf(registration),
                                                             Eigen::EigenvaluesOnly);
  return std::sqrt(eigen.eigenvalues().maxCoeff());
}

void SceneUnderstanding::GrowPlane(const std::vector<Vector3d>& plane_points_C,
                                   const world::SupportPlane& plane_C, const Pose& X_WC) {
  if (!belief_.plane_W) belief_.plane_W = world::Transform(X_WC, plane_C);
  plane_points_W_ = Thinned(std::move(plane_points_W_), InWorld(X_WC, plane_points_C), 0.02);
  belief_.plane_W->corners_A =
      perception::FitRectangle(plane_points_W_, belief_.plane_W->normal_A, belief_.plane_W->offset);
  belief_.plane_W->inliers = static_cast<int>(plane_points_W_.size());
}

/// Enters the other planes that a view shows: each grows the one that it continues, or is new.
void SceneUnderstanding::GrowFurther(const std::vector<perception::FurtherSupport>& further,
                                     const Pose& X_WC) {
  for (const perception::FurtherSupport& seen : further) {
    const world::SupportPlane seen_W = world::Transform(X_WC, seen.plane_C);
    const Vector3d middle_W = (seen_W.corners_A[0] + seen_W.corners_A[2]) / 2.0;
    const auto continues = [&](const world::SupportPlane& known) {
      return std::abs(known.HeightOf(middle_W)) < kSameLevel_m &&
             known.Covers(middle_W, kPlaneReach_m);
    };
    const auto known = std::find_if(belief_.further_W.begin(), belief_.further_W.end(), continues);
    const auto k = static_cast<std::size_t>(known - belief_.further_W.begin());
    if (known == belief_.further_W.end()) {
      belief_.further_W.push_back(seen_W);
      further_points_W_.emplace_back();
    }
    world::SupportPlane& plane_W = belief_.further_W[k];
    std::vector<Vector3d>& points_W = further_points_W_[k];
    points_W = Thinned(std::move(points_W), InWorld(X_WC, seen.points_C), 0.02);
    plane_W.corners_A = perception::FitRectangle(points_W, plane_W.normal_A, plane_W.offset);
    plane_W.inliers = static_cast<int>(points_W.size());
  }
}

/// The covariance of where a view's points lie in the map [m^2]: by its registration, at the middle
/// of the table, and by the map's own error.
Eigen::Matrix3d SceneUnderstanding::ErrorOf(
    const perception::ViewRegistration& registration) const {
  const Vector3d table_W =
      belief_.plane_W
          ? Vector3d((belief_.plane_W->corners_A[0] + belief_.plane_W->corners_A[2]) / 2.0)
          : registration.X_WC.translation();
  return fusion::PointCovariance(registration.covariance,
                                 table_W - registration.X_WC.translation()) +
         kModelSigma_m * kModelSigma_m * Eigen::Matrix3d::Identity();
}

SceneUnderstanding::Matched SceneUnderstanding::MatchClusters(
    std::vector<world::Cluster> clusters, const cv::Mat& depth, const hal::CameraModel& camera,
    const perception::ViewRegistration& registration) {
  const Pose& X_WC = registration.X_WC;
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

  std::vector<fusion::Seen> detections;
  for (const world::Cluster& cluster : clusters) {
    detections.emplace_back(InWorld(X_WC, cluster.points_C), config_.footprint_cell_m);
  }
  std::vector<fusion::Seen> objects;
  for (const int id : open) {
    objects.emplace_back(belief_.objects[id].points_W, config_.footprint_cell_m);
  }
  const fusion::MatchGate gate{config_.footprint_overlap, config_.match_sigmas,
                               ErrorOf(registration)};
  for (const fusion::Match& match : fusion::MatchSeen(detections, objects, gate)) {
    if (match.detections.empty()) continue;  // not seen this time
    std::vector<int> pixels;
    for (const int d : match.detections) pixels = UnionOfPixels(pixels, clusters[d].pixels);
    std::vector<int> ids;
    for (const int o : match.objects) ids.push_back(open[o]);
    std::vector<world::Cluster> left{perception::MakeCluster(std::move(pixels), depth, camera)};
    // What was told apart before takes its own share of what touches.
    for (const int id : ToldApart(ids)) {
      const PoseHypothesis& best = *belief_.objects[id].Best();
      world::Cluster share =
          perception::TakeExplained(ModelOf(best.model).mesh, X_WC.inverse() * best.X_WM, depth,
                                    camera, config_.min_leftover_points, &left);
      std::erase(ids, id);
      if (static_cast<int>(share.pixels.size()) < config_.segment.min_cluster_points) continue;
      matched.clusters.push_back(std::move(share));
      matched.objects.push_back(id);
    }
    if (left.empty()) continue;
    matched.clusters.push_back(std::move(left.front()));
    matched.objects.push_back(MergedObject(ids));
  }
  matched.open = static_cast<int>(matched.clusters.size());
  std::move(explained.begin(), explained.end(), std::back_inserter(matched.clusters));
  matched.objects.insert(matched.objects.end(), explained_by.begin(), explained_by.end());
  return matched;
}

/// Those of `ids` that some view accepted as a thing of its own, when there are several and none
/// stands in another: one cluster shows them all, but they are not one thing.
std::vector<int> SceneUnderstanding::ToldApart(const std::vector<int>& ids) const {
  std::vector<int> apart;
  for (const int id : ids) {
    const PoseHypothesis* best = belief_.objects[id].Best();
    if (best != nullptr && best->BestView()->hypothesis.verification.accepted) apart.push_back(id);
  }
  for (const int a : apart) {
    for (const int b : apart) {
      if (a == b) continue;
      const PoseHypothesis& one = *belief_.objects[a].Best();
      const PoseHypothesis& other = *belief_.objects[b].Best();
      if (perception::ShareInside(ModelOf(one.model), one.X_WM, ModelOf(other.model), other.X_WM) >
          kMostInside) {
        return {};
      }
    }
  }
  return apart.size() < 2 ? std::vector<int>{} : apart;
}

/// The detections of the newest view, taken from X_WC: recognition may cut or join what is open,
/// and with it the objects. What is verified is not recognised anew, only asked whether it still
/// holds (MultiViewVerification::Complete()).
std::vector<world::Detection> SceneUnderstanding::Recognise(const perception::View& view,
                                                            const Pose& X_WC, Matched* matched) {
  const auto first_explained = matched->clusters.begin() + matched->open;
  const std::vector<world::Cluster> open(matched->clusters.begin(), first_explained);
  perception::Regrouped found = perception::RecogniseRegrouping(
      perception::MakeView(view.color, view.depth, view.camera, view.plane_C, open, view.further_C),
      open, models_, config_.recognise);
  std::vector<int> objects(found.detections.size(), -1);
  for (std::size_t i = 0; i < found.detections.size(); ++i) {
    if (objects[i] >= 0) continue;
    std::vector<int> ids;
    for (const int source : found.sources[i]) ids.push_back(matched->objects[source]);
    objects[i] = MergedObject(ids);
    std::vector<std::size_t> parts;
    std::vector<PoseHypothesis> things;
    for (std::size_t k = i; k < found.detections.size(); ++k) {
      if (found.sources[k] != found.sources[i] || found.choices[k].hypothesis < 0) continue;
      const world::Hypothesis& h = found.detections[k].hypotheses[found.choices[k].hypothesis];
      parts.push_back(k);
      things.emplace_back();
      things.back().model = h.model;
      things.back().X_WM = X_WC * h.X_CM;
    }
    if (parts.size() < 2) continue;
    const std::vector<int> told_apart = SplitObject(objects[i], things);
    for (std::size_t k = 0; k < parts.size(); ++k) objects[parts[k]] = told_apart[k];
  }
  for (int i = matched->open; i < static_cast<int>(matched->clusters.size()); ++i) {
    found.detections.push_back({matched->clusters[i], {}, ""});
    objects.push_back(matched->objects[i]);
  }
  matched->objects = std::move(objects);
  matched->clusters.clear();
  for (const world::Detection& detection : found.detections) {
    matched->clusters.push_back(detection.cluster);
  }
  return std::move(found.detections);
}

/// The objects that each of `things` is, which a view told apart where object `id` is. When the
/// views before show several of them, they were one object by mistake: each gets what it explains
/// of the clusters there, and what was said of the whole is void.
std::vector<int> SceneUnderstanding::SplitObject(int id,
                                                 const std::vector<PoseHypothesis>& things) {
  struct Share {
    int view;
    world::Cluster cluster;
  };
  std::vector<std::vector<Share>> shares(things.size());
  const std::vector<world::Sighting> sightings = belief_.objects[id].sightings;
  for (const world::Sighting& sighting : sightings) {
    const world::Observation& seen = belief_.views[sighting.view];
    std::vector<world::Cluster> left{seen.detections[sighting.detection].cluster};
    for (std::size_t k = 0; k < things.size(); ++k) {
      world::Cluster share = perception::TakeExplained(ModelOf(things[k].model).mesh,
                                                       seen.X_WC.inverse() * things[k].X_WM,
                                                       seen.frame.depth, seen.camera, 0, &left);
      if (static_cast<int>(share.pixels.size()) < config_.segment.min_cluster_points) continue;
      shares[k].push_back({sighting.view, std::move(share)});
    }
  }
  // The one that was seen most stays the object.
  const auto pixels = [](const std::vector<Share>& of_one) {
    std::size_t sum = 0;
    for (const Share& share : of_one) sum += share.cluster.pixels.size();
    return sum;
  };
  const auto most =
      std::max_element(shares.begin(), shares.end(),
                       [&](const auto& a, const auto& b) { return pixels(a) < pixels(b); });
  const auto seen_before = std::count_if(shares.begin(), shares.end(),
                                         [](const auto& of_one) { return !of_one.empty(); });
  std::vector<int> ids;
  for (auto share = shares.begin(); share != shares.end(); ++share) {
    ids.push_back(share == most ? id : MergedObject({}));
  }
  if (seen_before < 2) return ids;
  TakeOutOfReference(id);
  ObjectBelief whole;
  whole.id = id;
  whole.looks_taken = belief_.objects[id].looks_taken;
  belief_.objects[id] = std::move(whole);
  for (std::size_t k = 0; k < things.size(); ++k) {
    for (Share& share : shares[k]) {
      AddDetection(share.view, std::move(share.cluster), &belief_.objects[ids[k]]);
    }
  }
  return ids;
}

/// Adds to a view before what of it shows `object` alone.
void SceneUnderstanding::AddDetection(int view, world::Cluster cluster, ObjectBelief* object) {
  std::vector<world::Detection>& detections = belief_.views[view].detections;
  const auto detection = static_cast<int>(detections.size());
  cv::Mat& labels = views_[view].labels;
  for (const int pixel : cluster.pixels) {
    labels.at<int>(pixel / labels.cols, pixel % labels.cols) = detection;
  }
  detections.push_back({std::move(cluster), {}, ""});
  AddSighting(view, detection, object);
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

/// Concludes what the object is; views are registered to the whole model of what is verified.
void SceneUnderstanding::Conclude(ObjectBelief* object) {
  Verification().Conclude(object);
  const bool stands_already =
      object->state == ObjectState::kVerified && modelled_W_.contains(object->id);
  if (object->state == ObjectState::kVerified && !stands_already) {
    Verification().ExamineTurns(object);
  }
  if (!object->history.empty()) object->reason += "; " + object->history;
  if (stands_already) {
    Verification().Refine(object);
    return;
  }
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
    if (object.state == ObjectState::kVerified && config_.known_in_map) {
      const PoseHypothesis& best = *object.Best();
      space_.Place(object.id, ModelOf(best.model).mesh, best.X_WM);
    } else {
      space_.TakeAway(object.id);
    }
  }
}

MultiViewVerification SceneUnderstanding::Verification() const {
  return {config_, task_, models_, belief_, views_, space_};
}

const perception::RecognitionModel& SceneUnderstanding::ModelOf(const std::string& name) const {
  return *perception::FindModel(models_, name);
}

}  // namespace secondlook::apps
