#include "apps/experiments/look_trial.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "apps/experiments/judge.h"
#include "lib/fusion/dempster_shafer.h"
#include "lib/kinematics/head.h"
#include "lib/perception/symmetry.h"
#include "lib/planning/choose_look.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using world::ObjectBelief;
using world::ObjectState;

constexpr double kDegree = std::numbers::pi / 180.0;
/// A belief farther from the object than this is about something else.
constexpr double kSameThing_m = 0.1;

std::string KeyOf(const std::vector<Stance>& stances) {
  std::string key;
  for (const Stance& s : stances) {
    key += fmt::format("{} {} {} {} {};", s.X_WB.x, s.X_WB.y, s.X_WB.yaw, s.head.pan, s.head.tilt);
  }
  return key;
}

LookConfig ConfigOf(const std::string& chooser) {
  LookConfig config;
  config.aspect_graph.strategy = chooser.substr(0, chooser.find(" on "));
  config.aspect_graph.fixed_step_deg = 120.0;  // round the object in three steps
  if (chooser == kPaper || chooser == kOursOnPaper) config.views.placed = 0;
  return config;
}

}  // namespace

LookTrial::LookTrial(const sim::Scene& scene, int target, const SceneUnderstanding& blank,
                     const world::Task& task, std::uint64_t seed)
    : target_(target),
      blank_(blank),
      task_(task),
      seed_(seed),
      camera_(scene, seed),
      carrier_(CarrierOf(camera_)) {}

Stance LookTrial::Facing(double azimuth, double distance) const {
  const Vector3d p_WO = object().X_WM * geometry::Bounds(object().mesh).center();
  Stance stance;
  stance.X_WB = {p_WO.x() + distance * std::cos(azimuth), p_WO.y() + distance * std::sin(azimuth),
                 WrapAngle(azimuth + std::numbers::pi)};
  const auto angles = kinematics::AimAt(carrier_.head, ToPose(stance.X_WB).inverse() * p_WO);
  if (angles) stance.head = {angles->pan, angles->tilt};
  return stance;
}

void LookTrial::Begin(const Stance& stance) {
  known_.clear();
  found_.clear();
  known_.try_emplace("", Extended({blank_, {}, stance, "", {}}, stance));
}

const Knowledge& LookTrial::After(const std::vector<Stance>& stances) {
  const std::string key = KeyOf(stances);
  const auto known = known_.find(key);
  if (known != known_.end()) return known->second;
  const std::vector<Stance> before(stances.begin(), stances.end() - 1);
  return known_.try_emplace(key, Extended(After(before), stances.back())).first->second;
}

Finding LookTrial::FindingAfter(const Stance& stance) {
  const std::string key = KeyOf({stance});
  if (const auto known = known_.find(key); known != known_.end()) return Judge(known->second);
  if (const auto found = found_.find(key); found != found_.end()) return found->second;
  return found_[key] = Judge(Extended(start(), stance));
}

Finding LookTrial::FindingIn(const Stance& stance) {
  const std::string key = "alone: " + KeyOf({stance});
  if (const auto found = found_.find(key); found != found_.end()) return found->second;
  return found_[key] = Judge(Extended({blank_, {}, stance, "", {}}, stance));
}

Finding LookTrial::Judge(const Knowledge& knowledge) const {
  Finding finding;
  finding.reason = knowledge.vain;
  const ObjectBelief* belief = Target(knowledge);
  if (belief == nullptr) {
    finding.lacks = WhatLacks(knowledge, finding);
    finding.reason += " nothing is believed to stand there";
    for (const ObjectBelief& other : knowledge.scene.belief().objects) {
      finding.reason += fmt::format("; object {}: {}", other.id, other.reason);
    }
    return finding;
  }
  if (finding.reason.empty()) finding.reason = belief->reason;
  for (const auto& [name, mass] : belief->masses.singletons) {
    finding.beliefs[name] = fusion::NormalisedBelief(belief->masses, name);
  }
  finding.verified = belief->state == ObjectState::kVerified;
  finding.unknown = belief->state == ObjectState::kUnknown;
  finding.candidate = !belief->Settled() && belief->Best() != nullptr;
  finding.probability = ProbabilityInLastView(knowledge, *belief);
  if (finding.verified && belief->Best()->model == object().name) {
    const world::PoseHypothesis& best = *belief->Best();
    const int view = best.BestView()->view;  // that shows it best
    finding.right = PoseIsRight(knowledge, view,
                                knowledge.scene.belief().views[view].X_WC.inverse() * best.X_WM);
  }
  if (!finding.right) finding.lacks = WhatLacks(knowledge, finding);
  return finding;
}

std::string LookTrial::WhatLacks(const Knowledge& knowledge, const Finding& finding) const {
  constexpr double kBelieved = 0.9;
  const ObjectBelief* belief = Target(knowledge);
  if (finding.verified) {
    return belief->Best()->model == object().name ? "wrong pose" : "wrong class";
  }
  if (!knowledge.vain.empty()) return "view not registered";
  if (belief == nullptr) return "not found";
  if (finding.unknown) return "called unknown";
  if (finding.BeliefIn(object().name) < kBelieved) return "class open";
  return belief->reason.find("its pose is open") != std::string::npos ? "pose open"
                                                                      : "pose not verified";
}

std::vector<world::Look> LookTrial::Candidates(const Knowledge& knowledge,
                                               const std::string& chooser,
                                               const world::VoxelSpace* map) const {
  const ObjectBelief* target = Target(knowledge);
  if (target == nullptr) return {};
  Question question;
  question.open = {target};
  question.map = map;
  LookPlanner planner(ConfigOf(chooser), UnderstandingConfig(), carrier_);
  for (const Vector3d& p_WC : knowledge.vain_views_W) planner.NoteVain(p_WC);
  Rng rng(ForkSeed(
      seed_, fmt::format("{} after {} views", chooser,
                         knowledge.scene.belief().views.size() + knowledge.vain_views_W.size())));
  std::vector<world::Look> looks =
      planner.Candidates(knowledge.scene, task_, question, knowledge.stance, &rng);
  planning::ChooseLook(&looks);
  return looks;
}

world::VoxelSpace LookTrial::MapOfLastView(const Knowledge& knowledge) {
  const UnderstandingConfig config;
  const world::SceneBelief& belief = knowledge.scene.belief();
  const world::Observation& last = belief.views.back();
  world::VoxelSpace space(config.voxel_space,
                          world::WorkspaceAbove(*belief.plane_W, config.voxel_space));
  space.Insert(last.frame.depth, last.camera, last.X_WC, config.depth_stride);
  return space;
}

double LookTrial::VisibleShare(const Stance& stance) {
  return camera_.VisibleShares(Look(stance).photo)[target_];
}

bool LookTrial::IsKnown() const {
  return perception::FindModel(blank_.models(), object().name) != nullptr;
}

/// Drawn from the place alone, so that all find the same there.
Sight LookTrial::Look(const Stance& stance) {
  Rng rng(ForkSeed(seed_, KeyOf({stance})));
  return LookFrom(stance, &rng, &camera_);
}

Knowledge LookTrial::Extended(Knowledge knowledge, const Stance& stance) {
  const Sight sight = Look(stance);
  knowledge.stance = stance;
  knowledge.vain = knowledge.scene.Add(sight.capture);
  if (knowledge.vain.empty()) {
    knowledge.true_X_WC.push_back(sight.photo.X_WC);
  } else {
    knowledge.vain_views_W.push_back(sight.capture.X_WC.translation());
  }
  return knowledge;
}

/// What is believed to be where the object is, through the eyes of a view that saw it; or null.
const ObjectBelief* LookTrial::Target(const Knowledge& knowledge) const {
  const Vector3d p_WO = object().X_WM * geometry::Bounds(object().mesh).center();
  const ObjectBelief* nearest = nullptr;
  double least = kSameThing_m;
  for (const ObjectBelief& belief : knowledge.scene.belief().objects) {
    if (belief.state == ObjectState::kRejected || belief.sightings.empty()) continue;
    const int view = belief.sightings.back().view;
    const Pose X_BelievedW =
        knowledge.scene.belief().views[view].X_WC * knowledge.true_X_WC[view].inverse();
    double distance = (belief.extent_W.center() - X_BelievedW * p_WO).norm();
    const world::PoseHypothesis* best = belief.Best();
    if (best != nullptr && best->model == object().name) {  // what was seen may be one end of it
      const Vector3d center_M = geometry::Bounds(object().mesh).center();
      distance = std::min(distance, (best->X_WM * center_M - X_BelievedW * p_WO).norm());
    }
    if (distance >= least) continue;
    least = distance;
    nearest = &belief;
  }
  return nearest;
}

/// Whether the object is at X_CM in the camera frame of a view, up to its symmetry.
bool LookTrial::PoseIsRight(const Knowledge& knowledge, int view, const Pose& X_CM) const {
  const JudgeConfig limits;
  const Pose X_CM_true = knowledge.true_X_WC[view].inverse() * object().X_WM;
  const auto& model = *perception::FindModel(knowledge.scene.models(), object().name);
  const perception::PoseDistance error =
      perception::DistanceUpToSymmetry(X_CM_true, X_CM, model.symmetry, model.center_M, true);
  return error.translation <= limits.max_m && error.rotation <= limits.max_deg * kDegree;
}

double LookTrial::ProbabilityInLastView(const Knowledge& knowledge,
                                        const ObjectBelief& belief) const {
  const world::Sighting& last = belief.sightings.back();
  const std::vector<world::Observation>& views = knowledge.scene.belief().views;
  if (!knowledge.vain.empty() || last.view + 1 != static_cast<int>(views.size())) return 0.0;
  double probability = 0.0;
  for (const world::Hypothesis& h : views[last.view].detections[last.detection].hypotheses) {
    if (h.model != object().name || !PoseIsRight(knowledge, last.view, h.X_CM)) continue;
    probability = std::max(probability, h.probability);
  }
  return probability;
}

const world::Look* ChosenOf(const std::vector<world::Look>& looks) {
  const auto chosen =
      std::find_if(looks.begin(), looks.end(), [](const world::Look& l) { return l.chosen; });
  return chosen == looks.end() ? nullptr : &*chosen;
}

Stance StanceOf(const world::Look& look) { return {look.X_WB, look.head}; }

double SecondsOf(const world::Look& look) {
  return look.seconds + planning::AspectGraphConfig().look_seconds;
}

}  // namespace secondlook::apps
