#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "apps/arm_looks.h"
#include "apps/exploration.h"
#include "apps/mission_config.h"
#include "apps/scene_understanding.h"
#include "lib/common/rng.h"
#include "lib/fusion/conclude.h"
#include "lib/geometry/ray_caster.h"
#include "lib/hal/guard.h"
#include "lib/perception/register_view.h"
#include "lib/planning/aspect_graph.h"
#include "lib/planning/common_ground.h"
#include "lib/planning/views.h"
#include "lib/world/look.h"
#include "lib/world/object_belief.h"
#include "lib/world/task.h"

namespace secondlook::apps {

/// The box in W around the model's own box at X_WM.
Eigen::AlignedBox3d PlacedBox(const geometry::Mesh& mesh, const Pose& X_WM);

/// What the next look is to answer.
struct Question {
  std::vector<const world::ObjectBelief*> open;   ///< That may have another look.
  std::vector<const world::ObjectBelief*> spent;  ///< Open, but had all the looks it may have.
  std::vector<Eigen::AlignedBox3d> hidden_W;      ///< Where something could stand unseen.
  std::optional<ScanTarget> scan;                 ///< A thing that is being modelled.
  const world::VoxelSpace* map{};  ///< To plan in instead of the scene's own; null: that.

  bool Empty() const { return open.empty() && hidden_W.empty() && !scan; }
};

/// The half of the cycle that decides where to look next: the candidates for all that is open, what
/// each would cost and bring. It remembers which looks were no help.
class LookPlanner {
 public:
  /// @throws ConfigError when `config` holds a value that is not valid.
  LookPlanner(const LookConfig& config, const UnderstandingConfig& understanding,
              planning::CameraCarrier carrier);

  /// Looks by this arm are offered beside the others from now on.
  void KnowArm(ArmLooks arm) { arm_.emplace(std::move(arm)); }

  /// Looks by the one-shot vote (one_shot_look.h) are offered, too. It must outlive this.
  void KnowClassifier(const perception::Classifier& classifier) { classifier_ = &classifier; }

  /// What is not known may be modelled, in this way.
  void KnowModelling(const ModellingConfig& config) { modelling_ = config; }

  /// The arm has set out along `motion` and stands at `q` [rad]. @pre it is known.
  void NoteArm(const hal::JointTrajectory& motion, const Eigen::VectorXd& q) {
    arm_->Follow(motion, q);
  }

  /// The arm takes no looks from now on, as its camera is lost. It is still folded before the base
  /// drives.
  void TakeNoArmLooks() { arm_looks_ = false; }
  bool TakesArmLooks() const { return arm_ && arm_looks_; }

  /// Likewise, as the arm itself is lost: it stays where it is, and unless it is folded there, so
  /// does the base.
  void LoseArm() {
    arm_looks_ = false;
    arm_lost_ = true;
  }

  /// At `now` something stands around this point of the floor that the map does not show. It may
  /// move on, so it is forgotten in a while; what still stands there then stops the base again.
  void Block(const Eigen::Vector2d& p_W, Time now) {
    blocked_.push_back({p_W, now + Seconds(config_.blocked_seconds)});
  }

  /// Looks for which the base or the arm would leave its workspace are refused. @pre the arm is
  /// known, if it is to take looks.
  /// @throws ConfigError when the arm is not within its own (ArmLooks::KeepWithin()).
  void KeepWithin(const hal::GuardConfig& limits);

  /// The view from this point taught nothing.
  void NoteVain(const Eigen::Vector3d& p_WC) { vain_views_W_.push_back(p_WC); }

  /// Every candidate for what `question` asks, with its checks and its score; none is chosen yet.
  /// @param rng Used by the strategy "random" alone. Not null.
  /// @pre scene.belief().plane_W.
  std::vector<world::Look> Candidates(const SceneUnderstanding& scene, const world::Task& task,
                                      const Question& question, const Stance& stance, Rng* rng);

 private:
  struct Blocked {
    Eigen::Vector2d p_W;
    Time until;
  };

  planning::AspectTarget TargetFor(const SceneUnderstanding& scene, const world::Task& task,
                                   const world::ObjectBelief& object);
  planning::AspectTarget TargetFor(const SceneUnderstanding& scene,
                                   const Eigen::AlignedBox3d& hidden_W) const;
  std::vector<world::Look> ScoreScans(const ScanTarget& target,
                                      const planning::CommonGround& ground,
                                      std::vector<world::Look> views, Rng* rng) const;
  bool ByLoss() const;
  const hal::CameraInfo& CameraOf(world::LookWay way) const;
  std::vector<world::Look> Score(const world::VoxelSpace& space,
                                 const planning::AspectTarget& target,
                                 const planning::CommonGround& ground, world::LookWay way,
                                 std::vector<world::Look> views, Rng* rng) const;
  void CheckScan(const ScanTarget& target, world::Look* look) const;
  void CheckNotInVain(world::Look* look) const;
  void CheckWithinWorkspace(world::Look* look) const;
  void WeighByCommonGround(const planning::CommonGround& ground,
                           const planning::AspectTarget& target, world::Look* look) const;
  void AddGainsBeside(const world::VoxelSpace& space, const planning::CommonGround& ground,
                      const std::vector<planning::AspectTarget>& targets,
                      const std::vector<int>& target_of, std::vector<world::Look>* looks) const;
  const geometry::RayCaster& CasterOf(const perception::RecognitionModel& model);

  LookConfig config_;
  ModellingConfig modelling_;
  fusion::ConcludeConfig conclude_;
  perception::RegisterConfig registration_;
  planning::CameraCarrier carrier_;
  std::optional<ArmLooks> arm_;
  bool arm_looks_{true};                                    // it can take looks
  bool arm_lost_{};                                         // it can not even be folded
  const perception::Classifier* classifier_{};              // null: none
  std::map<std::string, geometry::RayCaster> ray_casters_;  // by name of the model
  std::optional<hal::Workspace> workspace_;
  std::vector<Blocked> blocked_;
  std::vector<Eigen::Vector3d> vain_views_W_;
};

}  // namespace secondlook::apps
