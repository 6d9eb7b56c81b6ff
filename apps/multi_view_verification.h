#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/mission_config.h"
#include "lib/geometry/depth_rasteriser.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/view.h"
#include "lib/world/scene_belief.h"
#include "lib/world/task.h"
#include "lib/world/voxel_space.h"

namespace secondlook::apps {

/// The evidence for what an object may be: every hypothesis is asked of every view that shows it,
/// refined there and fused over the views; what is verified must be ahead of itself turned.
class MultiViewVerification {
 public:
  /// All must outlive it. `views` are belief.views as recognition looks at them; `models` has every
  /// model that is named.
  MultiViewVerification(const UnderstandingConfig& config, const world::Task& task,
                        const std::vector<perception::RecognitionModel>& models,
                        const world::SceneBelief& belief,
                        const std::vector<perception::View>& views, const world::VoxelSpace& space);

  /// Adds those hypotheses of `detection`, born in `view`, that the object does not have yet.
  void AddFresh(int view, const world::Detection& detection, world::ObjectBelief* object) const;

  /// Asks every view that shows the object about every hypothesis that it was not asked about
  /// yet. Drops those that come to where a better one is, or lean.
  void Complete(world::ObjectBelief* object);

  /// What the object is believed to be, from the evidence as it is.
  void Conclude(world::ObjectBelief* object) const;

  /// Refines the pose of a verified object in all its views together; it stays where they prefer it
  /// as it is.
  void Refine(world::ObjectBelief* object);

  /// Is the pose of a verified object held by what was seen? Turned a little, or to where its shape
  /// is the same, it must fit worse in the views together. A turn that fits better takes its place,
  /// one that fits nearly as well moves it to where it is as far ahead on either side; what then
  /// still fits nearly as well is a hypothesis of its own, and the object is open again.
  void ExamineTurns(world::ObjectBelief* object);

 private:
  using ObjectBelief = world::ObjectBelief;
  using PoseHypothesis = world::PoseHypothesis;

  Pose RefinedIn(const world::Sighting& sighting, const perception::RecognitionModel& model,
                 const Pose& X_WM);
  world::ViewEvidence Ask(const world::Sighting& sighting,
                          const perception::RecognitionModel& model, const Pose& X_CM);
  PoseHypothesis Turned(const ObjectBelief& object, const PoseHypothesis& best, const Pose& X_MS);
  std::optional<PoseHypothesis> RefinedTogether(const ObjectBelief& object,
                                                const PoseHypothesis& best);
  std::optional<PoseHypothesis> Recentred(const ObjectBelief& object, const PoseHypothesis& best,
                                          const Pose& X_MS);
  void DropConverged(ObjectBelief* object) const;
  void DropLeaning(ObjectBelief* object) const;
  void FusePose(PoseHypothesis* hypothesis) const;
  double LikelyFreeShare(const PoseHypothesis& hypothesis) const;
  int ClearViews(const ObjectBelief& object) const;
  const perception::RecognitionModel& ModelOf(const std::string& name) const;

  const UnderstandingConfig& config_;
  const world::Task& task_;
  const std::vector<perception::RecognitionModel>& models_;
  const world::SceneBelief& belief_;
  const std::vector<perception::View>& views_;
  const world::VoxelSpace& space_;
  geometry::DepthRasteriser rasteriser_;
};

}  // namespace secondlook::apps
