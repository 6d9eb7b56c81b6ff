#include "apps/data_association.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "apps/register_capture.h"
#include "lib/fusion/match.h"
#include "lib/geometry/kd_tree.h"
#include "lib/geometry/sampling.h"
#include "lib/perception/choose_together.h"
#include "lib/perception/explain.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using world::ObjectBelief;
using world::ObjectState;
using world::PoseHypothesis;

/// Two objects of one model nearer than this are its two ends.
constexpr double kSamePose_m = 0.03;
constexpr double kPointSpacing_m = 0.005;
/// Of two things that touch, as they were measured, no more of one stands in the other.
constexpr double kMostInside = 0.2;
/// What was seen of a thing is the surface of another where this share of its points is so near.
constexpr double kPartShare = 0.8;
constexpr double kOnSurface_m = 0.015;

std::vector<int> UnionOfPixels(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> all = a;
  all.insert(all.end(), b.begin(), b.end());
  return all;
}

}  // namespace

DataAssociation::DataAssociation(const UnderstandingConfig& config,
                                 const std::vector<perception::RecognitionModel>& models,
                                 world::SceneBelief* belief, std::vector<perception::View>* views,
                                 SceneMap* map)
    : config_(config), models_(models), belief_(*belief), views_(*views), map_(*map) {}

Associated DataAssociation::Associate(std::vector<world::Cluster> clusters, const cv::Mat& depth,
                                      const hal::CameraModel& camera,
                                      const perception::ViewRegistration& registration) {
  Associated explained = TakeVerified(depth, camera, registration.X_WC, &clusters);
  Associated things = MatchOpen(clusters, depth, camera, registration);
  things.open = static_cast<int>(things.clusters.size());
  std::move(explained.clusters.begin(), explained.clusters.end(),
            std::back_inserter(things.clusters));
  things.objects.insert(things.objects.end(), explained.objects.begin(), explained.objects.end());
  return things;
}

/// What is verified stands there as its whole model, and takes what that explains.
Associated DataAssociation::TakeVerified(const cv::Mat& depth, const hal::CameraModel& camera,
                                         const Pose& X_WC,
                                         std::vector<world::Cluster>* clusters) const {
  Associated explained;
  for (const ObjectBelief& object : belief_.objects) {
    if (object.state != ObjectState::kVerified) continue;
    world::Cluster cluster =
        TakeExplained(*object.Best(), X_WC, depth, camera, config_.min_leftover_points, clusters);
    if (!IsEnough(cluster)) continue;
    explained.clusters.push_back(std::move(cluster));
    explained.objects.push_back(object.id);
  }
  return explained;
}

Associated DataAssociation::MatchOpen(const std::vector<world::Cluster>& clusters,
                                      const cv::Mat& depth, const hal::CameraModel& camera,
                                      const perception::ViewRegistration& registration) {
  const Pose& X_WC = registration.X_WC;
  std::vector<fusion::Seen> detections;
  for (const world::Cluster& cluster : clusters) {
    detections.emplace_back(Transform(X_WC, cluster.points_C), config_.footprint_cell_m);
  }
  std::vector<int> open;  // ids
  std::vector<fusion::Seen> objects;
  for (const ObjectBelief& object : belief_.objects) {
    if (object.state == ObjectState::kRejected || object.state == ObjectState::kVerified) continue;
    open.push_back(object.id);
    objects.emplace_back(object.points_W, config_.footprint_cell_m);
  }
  const fusion::MatchGate gate{config_.footprint_overlap, config_.match_sigmas,
                               PointError(registration, belief_.plane_W)};
  Associated things;
  for (const fusion::Match& match : fusion::MatchSeen(detections, objects, gate)) {
    if (match.detections.empty()) continue;  // not seen this time
    std::vector<int> pixels;
    for (const int d : match.detections) pixels = UnionOfPixels(pixels, clusters[d].pixels);
    std::vector<int> ids;
    for (const int o : match.objects) ids.push_back(open[o]);
    std::vector<world::Cluster> left{perception::MakeCluster(std::move(pixels), depth, camera)};
    // What was told apart before takes its own share of what touches.
    for (const int id : ToldApart(ids)) {
      world::Cluster share = TakeExplained(*belief_.objects[id].Best(), X_WC, depth, camera,
                                           config_.min_leftover_points, &left);
      std::erase(ids, id);
      if (!IsEnough(share)) continue;
      things.clusters.push_back(std::move(share));
      things.objects.push_back(id);
    }
    if (left.empty()) continue;
    things.clusters.push_back(std::move(left.front()));
    things.objects.push_back(Merge(ids));
  }
  return things;
}

/// What of `clusters` is `thing`, taken out of them.
world::Cluster DataAssociation::TakeExplained(const PoseHypothesis& thing, const Pose& X_WC,
                                              const cv::Mat& depth, const hal::CameraModel& camera,
                                              int min_leftover_points,
                                              std::vector<world::Cluster>* clusters) const {
  return perception::TakeExplained(ModelOf(thing.model).mesh, X_WC.inverse() * thing.X_WM, depth,
                                   camera, min_leftover_points, clusters);
}

bool DataAssociation::IsEnough(const world::Cluster& cluster) const {
  return static_cast<int>(cluster.pixels.size()) >= config_.segment.min_cluster_points;
}

/// Those of `ids` that some view accepted as a thing of its own, when there are several and none
/// stands in another: one cluster shows them all, but they are not one thing.
std::vector<int> DataAssociation::ToldApart(const std::vector<int>& ids) const {
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

std::vector<int> DataAssociation::AfterRegrouping(const perception::Regrouped& found,
                                                  const Pose& X_WC,
                                                  const std::vector<int>& objects) {
  std::vector<int> regrouped(found.detections.size(), -1);
  for (std::size_t i = 0; i < found.detections.size(); ++i) {
    if (regrouped[i] >= 0) continue;
    std::vector<int> ids;
    for (const int source : found.sources[i]) ids.push_back(objects[source]);
    regrouped[i] = Merge(ids);
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
    const std::vector<int> told_apart = Split(regrouped[i], things);
    for (std::size_t k = 0; k < parts.size(); ++k) regrouped[parts[k]] = told_apart[k];
  }
  return regrouped;
}

/// The objects that each of `things` is, which a view told apart where object `id` is. When the
/// views before show several of them, they were one object by mistake: each gets what it explains
/// of the clusters there, and what was said of the whole is void.
std::vector<int> DataAssociation::Split(int id, const std::vector<PoseHypothesis>& things) {
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
      world::Cluster share =
          TakeExplained(things[k], seen.X_WC, seen.frame.depth, seen.camera, 0, &left);
      if (!IsEnough(share)) continue;
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
    ids.push_back(share == most ? id : Merge({}));
  }
  if (seen_before < 2) return ids;
  map_.RemoveModel(id);
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
void DataAssociation::AddDetection(int view, world::Cluster cluster, ObjectBelief* object) {
  std::vector<world::Detection>& detections = belief_.views[view].detections;
  const auto detection = static_cast<int>(detections.size());
  cv::Mat& labels = views_[view].labels;
  for (const int pixel : cluster.pixels) {
    labels.at<int>(pixel / labels.cols, pixel % labels.cols) = detection;
  }
  detections.push_back({std::move(cluster), {}, "", {}});
  AddSighting(view, detection, object);
}

int DataAssociation::Merge(const std::vector<int>& ids) {
  if (ids.empty()) {
    belief_.objects.emplace_back();
    belief_.objects.back().id = static_cast<int>(belief_.objects.size()) - 1;
    return belief_.objects.back().id;
  }
  ObjectBelief& whole = belief_.objects[ids.front()];
  for (const int id : ids) {
    if (ids.size() > 1) map_.RemoveModel(id);  // which of them is right is concluded anew
  }
  for (std::size_t i = 1; i < ids.size(); ++i) {
    ObjectBelief& part = belief_.objects[ids[i]];
    for (const world::Sighting& sighting : part.sightings) {
      const auto same_view =
          std::find_if(whole.sightings.begin(), whole.sightings.end(),
                       [&](const world::Sighting& s) { return s.view == sighting.view; });
      if (same_view == whole.sightings.end()) {
        whole.sightings.push_back(sighting);
      } else {
        MovePiece(sighting, *same_view, &whole);
      }
    }
    std::sort(whole.sightings.begin(), whole.sightings.end(),
              [](const auto& a, const auto& b) { return a.view < b.view; });
    whole.points_W = geometry::Thinned(std::move(whole.points_W), part.points_W, kPointSpacing_m);
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

/// Makes one cluster of two pieces of `whole` in one view; what was said of them is void.
void DataAssociation::MovePiece(const world::Sighting& from, const world::Sighting& to,
                                ObjectBelief* whole) {
  perception::View& view = views_[from.view];
  world::Observation& observation = belief_.views[from.view];
  world::Cluster& piece = observation.detections[from.detection].cluster;
  world::Cluster& kept = observation.detections[to.detection].cluster;
  for (const int pixel : piece.pixels) {
    view.labels.at<int>(pixel / view.camera.width, pixel % view.camera.width) = to.detection;
  }
  kept = perception::MakeCluster(UnionOfPixels(kept.pixels, piece.pixels), observation.frame.depth,
                                 observation.camera);
  piece = {};
  for (PoseHypothesis& h : whole->hypotheses) {
    std::erase_if(h.evidence, [&](const auto& e) { return e.view == from.view; });
  }
}

void DataAssociation::AddSighting(int view, int detection, ObjectBelief* object) const {
  const world::Observation& observation = belief_.views[view];
  object->sightings.push_back({view, detection});
  object->points_W = geometry::Thinned(
      std::move(object->points_W),
      Transform(observation.X_WC, observation.detections[detection].cluster.points_C),
      kPointSpacing_m);
  object->extent_W.setEmpty();
  for (const Vector3d& p : object->points_W) object->extent_W.extend(p);
}

bool DataAssociation::AreOne(const ObjectBelief& a, const ObjectBelief& b) const {
  return AreOneModel(a, b) || IsPartOf(a, b) || IsPartOf(b, a);
}

/// True when both are believed to be one model at one place: they are its two ends. Something in
/// front cut it in two, and each end was recognised by itself.
bool DataAssociation::AreOneModel(const ObjectBelief& a, const ObjectBelief& b) const {
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
bool DataAssociation::IsPartOf(const ObjectBelief& object, const ObjectBelief& whole) const {
  if (object.Settled() || whole.state != ObjectState::kVerified || object.points_W.empty()) {
    return false;
  }
  const PoseHypothesis& best = *whole.Best();
  const perception::RecognitionModel& model = ModelOf(best.model);
  if (!perception::BoxOf(model, best.X_WM).intersects(object.extent_W)) return false;
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

const perception::RecognitionModel& DataAssociation::ModelOf(const std::string& name) const {
  return *perception::FindModel(models_, name);
}

}  // namespace secondlook::apps
