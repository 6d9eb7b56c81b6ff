#include "apps/exploration.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "lib/common/hash.h"
#include "lib/geometry/thin_out.h"
#include "lib/perception/seen_through.h"
#include "lib/planning/boundary_search.h"

namespace secondlook::apps {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using world::ObjectBelief;
using world::ObjectState;
using world::SceneBelief;

/// A model outgrows its box when the thing comes so near to its sides, in shares of what is around.
constexpr double kRoom = 0.3;
/// A border so low goes on to the support, unseen [m].
constexpr double kRim = 0.025;
/// A view that sees through a larger share of the surface is of something else, or its pose is
/// wrong.
constexpr double kMaxSeeThrough = 0.25;

AlignedBox3d Grown(const AlignedBox3d& box, double by) {
  return {box.min() - Vector3d::Constant(by), box.max() + Vector3d::Constant(by)};
}

/// Room for the thing, and behind what is seen of it for as much again as it is wide.
AlignedBox3d BoxFor(const ObjectBelief& object, double around) {
  const double behind = 0.5 * object.extent_W.sizes().head<2>().maxCoeff();
  AlignedBox3d box = Grown(object.extent_W, around);
  box.min().head<2>().array() -= behind;
  box.max().head<2>().array() += behind;
  return box;
}

/// Points of all that stands beside `object`.
std::vector<Vector3d> PointsBeside(const ObjectBelief& object, const SceneBelief& belief,
                                   const AlignedBox3d& box_W) {
  std::vector<Vector3d> points_W;
  for (const ObjectBelief& other : belief.objects) {
    if (other.id == object.id || other.state == ObjectState::kRejected) continue;
    std::copy_if(other.points_W.begin(), other.points_W.end(), std::back_inserter(points_W),
                 [&](const Vector3d& p) { return box_W.contains(p); });
  }
  return points_W;
}

/// Why `view` cannot be of the thing whose surface is `surface`, where it stood; empty when it can.
std::string Contradiction(const world::PartialMesh& surface, const world::Observation& view) {
  std::vector<Vector3d> points_W;
  for (const Eigen::Vector3f& vertex : surface.mesh.vertices) {
    points_W.push_back(vertex.cast<double>());
  }
  const perception::SurfaceAgreement agreement =
      perception::ComparePoints(points_W, view.X_WC, view.frame.depth, view.camera);
  const int seen = agreement.matching + agreement.see_through;
  if (agreement.see_through <= kMaxSeeThrough * seen) return "";
  return fmt::format("it sees through {} of {} points of the surface", agreement.see_through, seen);
}

}  // namespace

world::ObjectModel AsModel(const world::ScannedModel& scanned) {
  const geometry::Mesh& mesh = scanned.mesh;
  const auto bytes = [](const auto& values) {
    return std::string_view(reinterpret_cast<const char*>(values.data()),
                            values.size() * sizeof(values[0]));
  };
  world::ObjectModel model;
  model.name = scanned.name;
  model.mesh = mesh;
  model.hash =
      Fnv1a(bytes(mesh.vertex_colors), Fnv1a(bytes(mesh.triangles), Fnv1a(bytes(mesh.vertices))));
  model.provenance = scanned.provenance;
  return model;
}

Exploration::Exploration(const ModellingConfig& config, const world::ObjectDatabase& known)
    : config_(config) {
  config_.Validate();
  for (const world::ObjectModel& model : known.models()) names_.insert(model.name);
}

std::optional<ModelledThing> Exploration::Work(const SceneBelief& belief, Time now) {
  if (!current_) {
    const ObjectBelief* object = LargestUnknown(belief);
    if (object == nullptr) return std::nullopt;
    Begin(*object, belief);
  }
  const ObjectBelief& object = belief.objects[current_->object];
  if (object.state != ObjectState::kUnknown) {
    ModelledThing thing = Drop(fmt::format("is no longer unknown: it {}", object.reason));
    done_.erase(thing.object);  // it may be unknown again one day
    return thing;
  }
  const double longest = object.extent_W.sizes().maxCoeff();
  if (longest > config_.largest_m) {
    return Drop(
        fmt::format("is {:.2f} m long; mission.modelling.largest_m = {} and what is larger is not "
                    "modelled",
                    longest, config_.largest_m));
  }
  if (!current_->model.box_W().contains(Grown(object.extent_W, kRoom * config_.around_m))) {
    Begin(object, belief);  // it is larger than it seemed
  }
  Enter(object, belief);
  const double coverage = current_->model.coverage().Reachable();
  if (coverage >= config_.coverage) {
    return Finish(belief, fmt::format("enough of it is seen: {:.0f} %", 100.0 * coverage), now);
  }
  if (static_cast<int>(current_->entered.size()) - current_->views_before >= config_.scans) {
    return Finish(belief,
                  fmt::format("the budget of {} scans for one thing is spent", config_.scans), now);
  }
  return std::nullopt;
}

std::optional<ScanTarget> Exploration::Target(const SceneBelief& belief,
                                              const world::VoxelSpace& space) {
  if (!current_) return std::nullopt;
  const ObjectBelief& object = belief.objects[current_->object];
  const PartialModel& model = current_->model;
  std::vector<planning::SurfaceTrend> trends =
      planning::FindTrends(model.surface(), *belief.plane_W, config_.borders);
  std::ranges::copy(planning::TrendsAcrossHoles(model.surface(), *belief.plane_W, config_.borders),
                    std::back_inserter(trends));
  gain_.emplace(*space.workspace(), model.surface(), trends, *belief.plane_W, config_.gain);
  std::vector<Vector3d> refused_W;
  for (const auto& [view, why] : current_->refused) {
    refused_W.push_back(belief.views[view].X_WC.translation());
  }
  return ScanTarget{object.id,
                    object.extent_W,
                    &*gain_,
                    model.coverage().filled,
                    model.scans(),
                    belief.views[object.sightings.back().view].X_WC.translation(),
                    std::move(refused_W)};
}

ModelledThing Exploration::Finish(const SceneBelief& belief, const std::string& why, Time now) {
  const perception::Coverage coverage = current_->model.coverage();
  const int scans = current_->model.scans();
  const world::PartialMesh surface = current_->model.surface();
  ModelledThing thing = Drop(why);
  if (surface.mesh.empty() || coverage.Reachable() < config_.least_coverage) {
    thing.reason +=
        fmt::format("; only {:.0f} % of it was seen in {} scans, and a model wants {:.0f} %",
                    100.0 * coverage.Reachable(), scans, 100.0 * config_.least_coverage);
    return thing;
  }
  Vector3d p_WM = geometry::Bounds(surface.mesh).center();
  p_WM -= belief.plane_W->HeightOf(p_WM) * belief.plane_W->normal_A;
  thing.X_WM.translation() = p_WM;
  thing.model = UnusedName();
  thing.scanned.name = thing.model;
  thing.scanned.full = StandingMesh(surface, p_WM, kRim);
  thing.scanned.mesh = geometry::ThinOut(thing.scanned.full, config_.detail_m);
  thing.scanned.provenance = {"depth camera", scans, coverage.Reachable(), now};
  return thing;
}

std::set<int> Exploration::NotToRecognise() const {
  std::set<int> objects;
  if (!current_) return objects;
  if (static_cast<int>(current_->entered.size()) >= config_.recognition_failures) {
    objects.insert(current_->object);
  }
  return objects;
}

const ObjectBelief* Exploration::LargestUnknown(const SceneBelief& belief) const {
  const ObjectBelief* largest = nullptr;
  for (const ObjectBelief& object : belief.objects) {
    if (object.state != ObjectState::kUnknown || done_.contains(object.id)) continue;
    if (largest == nullptr || object.extent_W.volume() > largest->extent_W.volume()) {
      largest = &object;
    }
  }
  return largest;
}

void Exploration::Begin(const ObjectBelief& object, const SceneBelief& belief) {
  const int views_before =
      current_ ? current_->views_before : static_cast<int>(object.sightings.size());
  current_.emplace(Current{object.id,
                           PartialModel(config_, BoxFor(object, config_.around_m), *belief.plane_W),
                           views_before});
}

/// Each view that shows it, and was not entered yet, is a scan; the nearest of them, which measures
/// finest, is the first. One that was refused may fit when the surface has grown.
void Exploration::Enter(const ObjectBelief& object, const SceneBelief& belief) {
  const auto distance = [&](int view) {
    return (belief.views[view].X_WC.translation() - object.extent_W.center()).norm();
  };
  std::vector<int> waiting;
  for (const world::Sighting& sighting : object.sightings) {
    if (current_->entered.insert(sighting.view).second) waiting.push_back(sighting.view);
  }
  std::ranges::stable_sort(waiting, {}, distance);
  for (const auto& [view, why] : current_->refused) waiting.push_back(view);
  for (bool grown = true; grown;) {
    grown = false;
    for (const int view : std::exchange(waiting, {})) {
      const std::string refused = Fuse(view, object, belief);
      if (refused.empty()) {
        grown = true;
        current_->refused.erase(view);
      } else {
        current_->refused[view] = refused;
        waiting.push_back(view);
      }
    }
  }
}

/// Returns why the view was refused; empty when it was fused.
std::string Exploration::Fuse(int view, const ObjectBelief& object, const SceneBelief& belief) {
  PartialModel& model = current_->model;
  std::string refused = Contradiction(model.surface(), belief.views[view]);
  if (refused.empty()) refused = model.Add(ScanOf(belief.views[view], model.box_W(), config_));
  if (!refused.empty()) return refused;
  model.Separate(object.points_W, PointsBeside(object, belief, model.box_W()));
  current_->coverage.push_back(model.coverage().Reachable());
  return "";
}

/// Ends the present thing, without a model.
ModelledThing Exploration::Drop(const std::string& why) {
  ModelledThing thing;
  thing.object = current_->object;
  thing.coverage = std::move(current_->coverage);
  for (const auto& [view, refusal] : current_->refused) {
    thing.refused.push_back(fmt::format("view {}: {}", view, refusal));
  }
  thing.reason = why;
  done_.insert(thing.object);
  current_.reset();
  gain_.reset();
  return thing;
}

std::string Exploration::UnusedName() {
  for (int i = 1;; ++i) {
    std::string name = fmt::format("object_{}", i);
    if (names_.insert(name).second) return name;
  }
}

}  // namespace secondlook::apps
