#pragma once

#include <map>
#include <vector>

#include <Eigen/Geometry>

#include "apps/mission_config.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/register_view.h"
#include "lib/world/observation.h"
#include "lib/world/scene_belief.h"
#include "lib/world/support_plane.h"
#include "lib/world/voxel_space.h"

namespace secondlook::apps {

/// What stands where, as the views have shown it: the voxels that looks are planned in, and the
/// cloud that views are registered to. In both, what is verified stands as its whole model.
class SceneMap {
 public:
  /// How well the surface of a verified model is known [m].
  static constexpr double kModelSigma_m = 0.003;

  explicit SceneMap(const UnderstandingConfig& config);

  const world::VoxelSpace& space() const { return space_; }
  const perception::ReferenceCloud& reference() const { return reference_; }

  /// Enters the newest of `views`, which was registered with `points_C`. When the plane has
  /// outgrown the workspace, the voxels are made anew from all of them, with room for more.
  void Enter(const std::vector<perception::SurfacePoint>& points_C,
             const perception::ViewRegistration& registration,
             const std::vector<world::Observation>& views, const world::SupportPlane& plane_W);

  /// Forgets what is known of the place of `object`, which is gone from there since `view`.
  void Forget(int view, const world::ObjectBelief& object);

  /// Registers views to the whole model of object `id` from now on.
  void AddModel(int id, const perception::RecognitionModel& model, const Pose& X_WM);
  bool HasModel(int id) const { return models_W_.contains(id); }
  /// No longer, if it did.
  void RemoveModel(int id);

  /// What stood in the map as object `from` is object `to`.
  void Rename(int from, int to);

  /// Lets what is verified, and nothing else, stand among the voxels as its whole model.
  void PlaceVerified(const std::vector<world::ObjectBelief>& objects,
                     const std::vector<perception::RecognitionModel>& models);

 private:
  /// A place from which something is gone since a view.
  struct Forgotten {
    int view{};
    Eigen::AlignedBox3d box_W;
  };

  void EnterVoxels(const world::Observation& view);

  world::VoxelSpaceConfig voxels_;
  int depth_stride_;
  world::VoxelSpace space_;
  perception::ReferenceCloud reference_;
  std::map<int, Eigen::AlignedBox3d> models_W_;  // what stands in it as whole models, by object
  std::vector<Forgotten> forgotten_;             // in the order of the views
};

}  // namespace secondlook::apps
