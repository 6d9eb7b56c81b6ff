#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "apps/experiments/free_camera.h"
#include "apps/experiments/sight.h"
#include "apps/look_planner.h"
#include "apps/scene_understanding.h"
#include "lib/world/task.h"

namespace secondlook::apps {

/// The ways to choose the next look that are compared, ours last: strategies
/// (planning::LookStrategy), where `on …` says among which candidates.
constexpr std::array<const char*, 7> kChoosers{"random",
                                               "nearest",
                                               "fixed step",
                                               "McGreavy",
                                               "McGreavy on all candidates",
                                               "expected loss on 38 poses",
                                               "expected loss"};
constexpr const char* kPaper = "McGreavy";  ///< On its 38 poses; others have placed ones, too.
constexpr const char* kPaperOnAll = "McGreavy on all candidates";
constexpr const char* kOursOnPaper = "expected loss on 38 poses";
constexpr const char* kOurs = "expected loss";

/// What is known after some views.
struct Knowledge {
  SceneUnderstanding scene;
  std::vector<Pose> true_X_WC;                ///< Of the camera, one a view of scene.belief().
  Stance stance;                              ///< Of the last view.
  std::string vain;                           ///< Why that taught nothing; empty when it did.
  std::vector<Eigen::Vector3d> vain_views_W;  ///< Where the camera was in views that did not.
};

/// What is known of the object that a trial is about.
struct Finding {
  bool candidate{};  ///< Open, with a hypothesis.
  bool verified{};   ///< Rightly or wrongly.
  bool unknown{};    ///< Settled: nothing that is known fits.
  bool right{};      ///< Verified by its true name, within 10 mm and 5 degrees.
  std::map<std::string, double> beliefs;  ///< By class.
  /// Calibrated, of its true name and pose, by the last view alone (world::Hypothesis); 0 without.
  double probability{};
  std::string reason;  ///< Why it is in its state, or why the last view taught nothing.
  /// What is amiss, one of a few kinds; empty when it is right.
  std::string lacks;

  double BeliefIn(const std::string& name) const {
    const auto found = beliefs.find(name);
    return found == beliefs.end() ? 0.0 : found->second;
  }
};

/// An object in a scene, the places from which a robot could look at it, and what it would know
/// then. What is captured depends on the seed and the place alone, so all ways to choose looks find
/// the same views. The robot is put where it looks from rather than driven there, with all the
/// errors of one that drove.
class LookTrial {
 public:
  /// `blank` knows the models and nothing else; it must outlive this. The object is `target` of
  /// scene.objects.
  LookTrial(const sim::Scene& scene, int target, const SceneUnderstanding& blank,
            const world::Task& task, std::uint64_t seed);

  /// The robot at `distance` [m] from the object, at `azimuth` [rad] around it, looking at it.
  Stance Facing(double azimuth, double distance) const;

  /// Forgets all and takes a first view.
  void Begin(const Stance& stance);
  /// What was known after the first view. @pre Begin().
  const Knowledge& start() const { return known_.at(""); }
  /// What is known after the first view and those from `stances`. Remembered.
  const Knowledge& After(const std::vector<Stance>& stances);
  /// What is known of the object by the first view and one from `stance`; only this is remembered.
  Finding FindingAfter(const Stance& stance);
  /// What a view from `stance` tells by itself.
  Finding FindingIn(const Stance& stance);

  Finding Judge(const Knowledge& knowledge) const;

  /// The candidates as `chooser` scores them, one of them chosen if any is possible; none when
  /// nothing is believed to be where the object is. Planned in `map` when that is not null.
  std::vector<world::Look> Candidates(const Knowledge& knowledge, const std::string& chooser,
                                      const world::VoxelSpace* map = nullptr) const;

  /// What the last view of `knowledge` alone shows of the world. @pre there is a view.
  static world::VoxelSpace MapOfLastView(const Knowledge& knowledge);

  /// The share of the object's silhouette that a view from `stance` shows.
  double VisibleShare(const Stance& stance);

  /// Whether a model of the object is known.
  bool IsKnown() const;

  const sim::PlacedObject& object() const { return camera_.world().objects()[target_]; }

 private:
  Sight Look(const Stance& stance);
  Knowledge Extended(Knowledge knowledge, const Stance& stance);
  const world::ObjectBelief* Target(const Knowledge& knowledge) const;
  std::string WhatLacks(const Knowledge& knowledge, const Finding& finding) const;
  bool PoseIsRight(const Knowledge& knowledge, int view, const Pose& X_CM) const;
  double ProbabilityInLastView(const Knowledge& knowledge, const world::ObjectBelief& belief) const;

  int target_;
  const SceneUnderstanding& blank_;
  world::Task task_;
  std::uint64_t seed_;
  FreeCamera camera_;
  planning::CameraCarrier carrier_;
  std::map<std::string, Knowledge> known_;  // by the stances after the first
  std::map<std::string, Finding> found_;    // likewise
};

/// The look that is chosen; null when none is.
const world::Look* ChosenOf(const std::vector<world::Look>& looks);

Stance StanceOf(const world::Look& look);

/// Robot time of a look [s]: getting there, and looking.
double SecondsOf(const world::Look& look);

}  // namespace secondlook::apps
