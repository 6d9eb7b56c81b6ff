#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "apps/capture.h"
#include "apps/data_association.h"
#include "apps/mission_config.h"
#include "apps/multi_view_verification.h"
#include "apps/scene_map.h"
#include "apps/support_planes.h"
#include "lib/perception/appearance/classifier.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/register_view.h"
#include "lib/perception/view.h"
#include "lib/world/object_database.h"
#include "lib/world/scene_belief.h"
#include "lib/world/task.h"
#include "lib/world/voxel_space.h"

namespace secondlook::apps {

/// The half of the cycle that understands: each view is registered to the map, cut into things,
/// matched with what is known, recognised, and fused into the belief.
///
/// Every hypothesis is asked of every view that shows its object, whichever view it was born in; so
/// what is believed does not depend on the order of the views, only on which there were. What a
/// view sees through is gone from its place; what is verified elsewhere then is the same object,
/// moved, when its model is the same and it is near, else another.
class SceneUnderstanding {
 public:
  SceneUnderstanding(const UnderstandingConfig& config, const world::Task& task,
                     const world::ObjectDatabase& database);

  /// Adds a view. Returns why nothing could be learned from it (no support plane in it, it cannot
  /// be registered), and changes nothing then; empty when it was added.
  std::string Add(const Capture& capture);

  const world::SceneBelief& belief() const { return belief_; }
  const world::VoxelSpace& space() const { return map_.space(); }
  /// Of X_WC of the newest view. @pre there is one.
  const perception::PoseCovariance& covariance() const { return covariance_; }
  /// What views are registered to.
  const perception::ReferenceCloud& reference() const { return map_.reference(); }
  const std::vector<perception::RecognitionModel>& models() const { return models_; }

  /// Knows one model more from the next view on. What was called unknown is open again.
  /// @pre none of its name is known.
  void Learn(const world::ObjectModel& model);

  /// Object `id` has been modelled where it stands, at X_WM, and is `model`: it is known from now
  /// on, and every view so far is asked whether it is that.
  /// @pre none of its name is known.
  void LearnModelled(int id, const world::ObjectModel& model, const Pose& X_WM);

  /// The next views do not ask what these objects are; that they are there they show all the same.
  void DoNotRecognise(std::set<int> objects) { not_recognised_ = std::move(objects); }

  /// Appends `text` to the reason of object `id`, for good.
  void Note(int id, const std::string& text);

  /// Asks `classifier`, which must outlive this, what each thing looks like, from the next view on.
  void KnowClassifier(const perception::Classifier& classifier) { classifier_ = &classifier; }

  /// What is wanted from now on.
  void SetTask(const world::Task& task) { task_ = task; }

  /// Notes that a look was taken for the sake of object `id`.
  void CountLook(int id) { ++belief_.objects[id].looks_taken; }

 private:
  /// A verified thing that is no longer where it stood.
  struct GoneThing {
    int id{};
    int view{};  // that sees through it
    std::string model;
    Eigen::Vector3d center_W;
  };

  void InsertModel(const world::ObjectModel& model);
  std::vector<int> Gone(const Capture& capture, const Pose& X_WC) const;
  void Unlearn(int view, world::ObjectBelief* object);
  std::string Contradiction(const Capture& capture, const Pose& X_WC,
                            const std::vector<int>& gone) const;
  void FollowMoved();
  void MergeDuplicates();
  std::vector<world::Detection> Recognise(const perception::View& view, const Pose& X_WC,
                                          Associated* things);
  void Conclude(world::ObjectBelief* object);
  DataAssociation Association();
  MultiViewVerification Verification() const;
  const perception::RecognitionModel& ModelOf(const std::string& name) const;

  UnderstandingConfig config_;
  world::Task task_;
  std::vector<perception::RecognitionModel> models_;
  const perception::Classifier* classifier_{};  // null: things are known by shape alone
  SceneMap map_;
  SupportPlanes planes_;
  std::vector<GoneThing> gone_;          // and not found again
  std::set<int> not_recognised_;         // objects, as they are being modelled
  std::vector<perception::View> views_;  // as recognition looks at belief_.views
  world::SceneBelief belief_;
  perception::PoseCovariance covariance_{perception::PoseCovariance::Zero()};
};

}  // namespace secondlook::apps
