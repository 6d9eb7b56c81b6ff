#include "apps/scene_map.h"

#include <algorithm>

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using world::ObjectBelief;

}  // namespace

SceneMap::SceneMap(const UnderstandingConfig& config)
    : voxels_(config.voxel_space), depth_stride_(config.depth_stride), space_(config.voxel_space) {}

void SceneMap::Enter(const std::vector<perception::SurfacePoint>& points_C,
                     const perception::ViewRegistration& registration,
                     const std::vector<world::Observation>& views,
                     const world::SupportPlane& plane_W) {
  reference_.AddView(points_C, registration.X_WC, registration.covariance);
  const world::BrickGrid* workspace = space_.workspace();
  const bool covered = workspace != nullptr &&
                       std::all_of(plane_W.corners_A.begin(), plane_W.corners_A.end(),
                                   [&](const Vector3d& p) { return workspace->Contains(p); });
  if (covered) {
    EnterVoxels(views.back());
    return;
  }
  space_ = world::VoxelSpace(voxels_, world::WorkspaceAbove(plane_W, voxels_));
  for (int view = 0; view < static_cast<int>(views.size()); ++view) {
    for (const Forgotten& forgotten : forgotten_) {
      if (forgotten.view == view) space_.RemoveRegion(forgotten.box_W);
    }
    EnterVoxels(views[view]);
  }
}

void SceneMap::EnterVoxels(const world::Observation& view) {
  space_.Insert(view.frame.depth, view.camera, view.X_WC, depth_stride_);
}

void SceneMap::Forget(int view, const ObjectBelief& object) {
  Eigen::AlignedBox3d box_W = object.extent_W;
  const auto model = models_W_.find(object.id);
  if (model != models_W_.end()) box_W.extend(model->second);
  box_W =
      Eigen::AlignedBox3d(box_W.min().array() - kModelSigma_m, box_W.max().array() + kModelSigma_m);
  RemoveModel(object.id);
  reference_.Remove(box_W);
  space_.TakeAway(object.id);
  space_.RemoveRegion(box_W);
  forgotten_.push_back({view, box_W});
}

void SceneMap::AddModel(int id, const perception::RecognitionModel& model, const Pose& X_WM) {
  reference_.AddModel(model.mesh, X_WM, kModelSigma_m);
  models_W_[id] = perception::BoxOf(model, X_WM);
}

void SceneMap::RemoveModel(int id) {
  const auto model = models_W_.find(id);
  if (model == models_W_.end()) return;
  reference_.Remove(model->second);
  models_W_.erase(model);
}

void SceneMap::Rename(int from, int to) {
  if (const auto model = models_W_.extract(from)) models_W_[to] = model.mapped();
  space_.TakeAway(from);
}

void SceneMap::PlaceVerified(const std::vector<ObjectBelief>& objects,
                             const std::vector<perception::RecognitionModel>& models) {
  for (const ObjectBelief& object : objects) {
    if (object.state == world::ObjectState::kVerified) {
      const world::PoseHypothesis& best = *object.Best();
      space_.Place(object.id, perception::FindModel(models, best.model)->mesh, best.X_WM);
    } else {
      space_.TakeAway(object.id);
    }
  }
}

}  // namespace secondlook::apps
