#include "apps/experiments/judge.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lib/common/error.h"
#include "lib/geometry/mesh.h"
#include "lib/perception/symmetry.h"
#include "sim/world.h"

namespace secondlook::apps {
namespace {

using world::ObjectBelief;
using world::ObjectState;

constexpr double kDegrees = 180.0 / std::numbers::pi;
/// A belief farther from a thing than this is about something else.
constexpr double kSameThing_m = 0.08;

class Court {
 public:
  Court(const Mission& mission, const sim::World& world, const JudgeConfig& config)
      : mission_(mission), world_(world), config_(config) {
    table_height_ = world.scene().table.height;
  }

  std::vector<Verdict> Judge() {
    std::vector<Verdict> verdicts;
    std::vector<char> taken(mission_.belief().objects.size(), 0);
    const std::vector<const ObjectBelief*> about = Matches();
    for (std::size_t i = 0; i < about.size(); ++i) {
      const sim::PlacedObject& thing = world_.objects()[i];
      if (thing.role == sim::Role::kObstacle) continue;
      if (about[i] != nullptr) taken[about[i]->id] = 1;
      verdicts.push_back(AboutThing(thing, about[i]));
    }
    for (const ObjectBelief& object : mission_.belief().objects) {
      if (object.state != ObjectState::kVerified || taken[object.id]) continue;
      Verdict verdict;
      verdict.kind = Verdict::Kind::kWrong;
      verdict.object = object.id;
      verdict.belief = object.Best()->model;
      verdicts.push_back(verdict);
    }
    return verdicts;
  }

 private:
  /// Where the camera truly was. Those on the head and in the hand count their frames by
  /// themselves; the right one is the one that was about where it was believed to be.
  Pose TruePoseOf(const world::Observation& view) const {
    const Pose* nearest = nullptr;
    for (const auto* views : {&world_.views(), &world_.hand_views()}) {
      for (const sim::TrueView& v : *views) {
        if (v.sequence != view.frame.sequence) continue;
        const auto off = [&](const Pose& X_WC) {
          return (X_WC.translation() - view.X_WC.translation()).norm();
        };
        if (nearest == nullptr || off(v.X_WC) < off(*nearest)) nearest = &v.X_WC;
      }
    }
    if (nearest == nullptr) {
      Throw<InvalidArgument>("frame {} was never grabbed", view.frame.sequence);
    }
    return *nearest;
  }

  /// Where the centre of the object is believed to be, in the true W: seen through the true pose of
  /// a camera that saw it, so that the error of the robot's localisation does not count.
  Eigen::Vector3d TrueCenterOf(const ObjectBelief& object, const sim::PlacedObject& thing) const {
    const world::Observation& view = mission_.belief().views[object.sightings.back().view];
    const Pose X_TrueW = TruePoseOf(view) * view.X_WC.inverse();
    const bool posed = object.state == ObjectState::kVerified && object.Best()->model == thing.name;
    return X_TrueW * (posed ? object.Best()->X_WM * geometry::Bounds(thing.mesh).center()
                            : object.extent_W.center());
  }

  /// The belief about each thing, or null.
  std::vector<const ObjectBelief*> Matches() const {
    struct Pair {
      double cost;
      std::size_t thing;
      const ObjectBelief* object;
    };
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < world_.objects().size(); ++i) {
      const sim::PlacedObject& thing = world_.objects()[i];
      if (thing.role == sim::Role::kObstacle) continue;
      const Eigen::Vector3d center_W = thing.X_WM * geometry::Bounds(thing.mesh).center();
      for (const ObjectBelief& object : mission_.belief().objects) {
        if (object.state == ObjectState::kRejected) continue;
        const double distance = (TrueCenterOf(object, thing) - center_W).norm();
        if (distance >= kSameThing_m) continue;
        const bool agrees =
            object.state == ObjectState::kVerified && object.Best()->model == thing.name;
        pairs.push_back({agrees ? distance - kSameThing_m : distance, i, &object});
      }
    }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& a, const Pair& b) { return a.cost < b.cost; });
    std::vector<const ObjectBelief*> about(world_.objects().size(), nullptr);
    std::vector<char> taken(mission_.belief().objects.size(), 0);
    for (const Pair& pair : pairs) {
      if (about[pair.thing] != nullptr || taken[pair.object->id]) continue;
      about[pair.thing] = pair.object;
      taken[pair.object->id] = 1;
    }
    return about;
  }

  Verdict AboutThing(const sim::PlacedObject& thing, const ObjectBelief* object) {
    Verdict verdict;
    verdict.truth = thing.name;
    verdict.known = thing.role == sim::Role::kKnown;
    verdict.kind = verdict.known ? Verdict::Kind::kMissed : Verdict::Kind::kUnknownOpen;
    if (object == nullptr) return verdict;
    verdict.object = object->id;
    if (object->state == ObjectState::kUnknown) {
      verdict.belief = "unknown";
      if (!verdict.known) verdict.kind = Verdict::Kind::kUnknownRight;
    }
    if (object->state != ObjectState::kVerified) return verdict;
    verdict.belief = object->Best()->model;
    verdict.kind = Verdict::Kind::kWrong;
    if (verdict.known && verdict.belief == thing.name) Measure(*object, thing, &verdict);
    return verdict;
  }

  void Measure(const ObjectBelief& object, const sim::PlacedObject& thing, Verdict* verdict) {
    const perception::Symmetry symmetry = perception::FindSymmetry(thing.mesh);
    const Eigen::Vector3d center_M = geometry::Bounds(thing.mesh).center();
    const world::Observation& view = mission_.belief().views[object.Best()->BestView()->view];
    const Pose X_CM_true = TruePoseOf(view).inverse() * thing.X_WM;
    const Pose X_CM = view.X_WC.inverse() * object.Best()->X_WM;
    const perception::PoseDistance error =
        perception::DistanceUpToSymmetry(X_CM_true, X_CM, symmetry, center_M, true);
    verdict->error_m = error.translation;
    verdict->error_deg = error.rotation * kDegrees;
    const bool right = error.translation <= config_.max_m && verdict->error_deg <= config_.max_deg;
    verdict->kind = right ? Verdict::Kind::kRight : Verdict::Kind::kWrong;

    const Pose& X_WM = object.Best()->X_WM;
    const world::SupportPlane& plane_W = *mission_.belief().plane_W;
    const double true_height = (thing.X_WM * center_M).z() - table_height_;
    verdict->height_error_m = std::abs(plane_W.HeightOf(X_WM * center_M) - true_height);
    // The tilt between the directions that "up" has in the model, by the truth and by the belief.
    const Eigen::Vector3d up_true_M = thing.X_WM.linear().transpose() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up_M = X_WM.linear().transpose() * plane_W.normal_A;
    double best = std::numbers::pi;
    for (const perception::SymmetryMotion& motion : symmetry.motions) {
      if (!motion.keeps_color) continue;
      const double cosine = (motion.X_MS.linear() * up_M).dot(up_true_M);
      best = std::min(best, std::acos(std::clamp(cosine, -1.0, 1.0)));
    }
    verdict->tilt_error_deg = best * kDegrees;
  }

  const Mission& mission_;
  const sim::World& world_;
  JudgeConfig config_;
  double table_height_{};
};

}  // namespace

const char* ToString(Verdict::Kind kind) {
  switch (kind) {
    case Verdict::Kind::kRight:
      return "right";
    case Verdict::Kind::kMissed:
      return "missed";
    case Verdict::Kind::kWrong:
      return "wrong";
    case Verdict::Kind::kUnknownRight:
      return "unknown right";
    case Verdict::Kind::kUnknownOpen:
      return "unknown open";
  }
  return "missed";
}

std::vector<Verdict> Judge(const Mission& mission, const sim::World& world,
                           const JudgeConfig& config) {
  return Court(mission, world, config).Judge();
}

}  // namespace secondlook::apps
