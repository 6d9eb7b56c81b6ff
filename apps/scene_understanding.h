#pragma once

#include <map>
#include <string>
#include <vector>

#include "apps/capture.h"
#include "apps/mission_config.h"
#include "apps/multi_view_verification.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/register_view.h"
#include "lib/perception/segment.h"
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
  const world::VoxelSpace& space() const { return space_; }
  /// What views are registered to.
  const perception::ReferenceCloud& reference() const { return reference_; }
  const std::vector<perception::RecognitionModel>& models() const { return models_; }

  /// Knows one model more from the next view on. What was called unknown is open again.
  /// @pre none of its name is known.
  void Learn(const world::ObjectModel& model);

  /// What is wanted from now on.
  void SetTask(const world::Task& task) { task_ = task; }

  /// Notes that a look was taken for the sake of object `id`.
  void CountLook(int id) { ++belief_.objects[id].looks_taken; }

 private:
  /// The things of a view, and which object each of them is: clusters[i] is objects[i]. Those that
  /// are to be recognised come first, then those that a verified object explains.
  struct Matched {
    std::vector<world::Cluster> clusters;
    std::vector<int> objects;  // ids
    int open{};                // how many are to be recognised
  };

  /// A place from which something is gone since a view.
  struct Unlearned {
    int view{};
    Eigen::AlignedBox3d box_W;
  };

  /// A verified thing that is no longer where it stood.
  struct GoneThing {
    int id{};
    int view{};  // that sees through it
    std::string model;
    Eigen::Vector3d center_W;
  };

  perception::ViewRegistration Register(std::vector<perception::SurfacePoint> points_C,
                                        const Capture& capture,
                                        const perception::Segmentation& cut) const;
  std::vector<perception::SurfacePoint> HiddenSides(const Capture& capture,
                                                    const perception::Segmentation& cut) const;
  double SpreadOf(const perception::ViewRegistration& registration) const;
  std::vector<int> Gone(const Capture& capture, const Pose& X_WC) const;
  void Unlearn(int view, world::ObjectBelief* object);
  std::string Contradiction(const Capture& capture, const Pose& X_WC,
                            const std::vector<int>& gone) const;
  void GrowPlane(const std::vector<Eigen::Vector3d>& plane_points_C,
                 const world::SupportPlane& plane_C, const Pose& X_WC);
  void GrowFurther(const std::vector<perception::FurtherSupport>& further, const Pose& X_WC);
  Matched MatchClusters(std::vector<world::Cluster> clusters, const cv::Mat& depth,
                        const hal::CameraModel& camera,
                        const perception::ViewRegistration& registration);
  Eigen::Matrix3d ErrorOf(const perception::ViewRegistration& registration) const;
  void FollowMoved();
  bool AreOneModel(const world::ObjectBelief& a, const world::ObjectBelief& b) const;
  bool IsPartOf(const world::ObjectBelief& object, const world::ObjectBelief& whole) const;
  void MergeDuplicates();
  std::vector<int> ToldApart(const std::vector<int>& ids) const;
  std::vector<world::Detection> Recognise(const perception::View& view, const Pose& X_WC,
                                          Matched* matched);
  std::vector<int> SplitObject(int id, const std::vector<world::PoseHypothesis>& things);
  void AddDetection(int view, world::Cluster cluster, world::ObjectBelief* object);
  int MergedObject(const std::vector<int>& ids);
  void AddSighting(int view, int detection, world::ObjectBelief* object);
  MultiViewVerification Verification() const;
  void Conclude(world::ObjectBelief* object);
  void TakeOutOfReference(int id);
  void EnterNewestView();
  void PlaceVerified();
  const perception::RecognitionModel& ModelOf(const std::string& name) const;

  UnderstandingConfig config_;
  world::Task task_;
  std::vector<perception::RecognitionModel> models_;
  world::VoxelSpace space_;
  perception::ReferenceCloud reference_;
  std::map<int, Eigen::AlignedBox3d> modelled_W_;  // what stands in it as whole models, by object
  std::vector<Unlearned> unlearned_;               // in the order of the views
  std::vector<GoneThing> gone_;                    // and not found again
  std::vector<Eigen::Vector3d> plane_points_W_;
  std::vector<std::vector<Eigen::Vector3d>> further_points_W_;  // by plane of belief_.further_W
  std::vector<perception::View> views_;  // as recognition looks at belief_.views
  world::SceneBelief belief_;
};

}  // namespace secondlook::apps
