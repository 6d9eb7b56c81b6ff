#include "lib/world/voxel_space.h"

#include <algorithm>
#include <cmath>

#include "lib/common/error.h"
#include "lib/world/solid_voxels.h"

namespace secondlook::world {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// Of OctoMap: what is marked is as sure as a voxel may be.
const float kSurelyFree = LogOdds(OccupancyModel{}.min_probability);
const float kSurelyOccupied = LogOdds(OccupancyModel{}.max_probability);

void CheckBox(const AlignedBox3d& box_W, const char* what) {
  if (box_W.min().allFinite() && box_W.max().allFinite()) return;
  Throw<InvalidArgument>("voxel space: {} from ({}, {}, {}) to ({}, {}, {}) m is not finite", what,
                         box_W.min().x(), box_W.min().y(), box_W.min().z(), box_W.max().x(),
                         box_W.max().y(), box_W.max().z());
}

/// A first voxel for the surroundings, which move to what is entered.
AlignedBox3d OneVoxel(const VoxelSpaceConfig& config) {
  config.Validate();
  return {Vector3d::Zero(), Vector3d::Constant(config.surroundings_voxel_m)};
}

}  // namespace

void VoxelSpaceConfig::Validate() const {
  const auto check_voxel = [](double value, const char* name) {
    if (!(value >= 0.001 && value <= 1.0)) {
      Throw<ConfigError>("{} = {} must lie in 0.001..1", name, value);
    }
  };
  check_voxel(voxel_m, "voxel_m");
  check_voxel(surroundings_voxel_m, "surroundings_voxel_m");
  if (!(max_range_m > std::max(voxel_m, surroundings_voxel_m) && max_range_m <= 100.0)) {
    Throw<ConfigError>("max_range_m = {} must lie in a voxel's edge..100", max_range_m);
  }
  if (!(hit_probability > 0.5 && hit_probability < 1.0)) {
    Throw<ConfigError>("hit_probability = {} must lie between 0.5 and 1", hit_probability);
  }
  if (!(miss_probability > 0.0 && miss_probability < 0.5)) {
    Throw<ConfigError>("miss_probability = {} must lie between 0 and 0.5", miss_probability);
  }
  if (!(likely_free_below > 0.0 && likely_free_below <= 0.5)) {
    Throw<ConfigError>("likely_free_below = {} must lie in 0..0.5", likely_free_below);
  }
  if (!(workspace_height_m >= voxel_m && workspace_height_m <= 5.0)) {
    Throw<ConfigError>("workspace_height_m = {} must lie in voxel_m..5", workspace_height_m);
  }
  if (!(workspace_margin_m >= 0.0 && workspace_margin_m <= 2.0)) {
    Throw<ConfigError>("workspace_margin_m = {} must lie in 0..2", workspace_margin_m);
  }
}

AlignedBox3d WorkspaceAbove(const SupportPlane& plane_W, const VoxelSpaceConfig& config) {
  AlignedBox3d box_W;
  for (const Vector3d& corner_W : plane_W.corners_A) {
    box_W.extend(corner_W).extend(corner_W + config.workspace_height_m * Vector3d::UnitZ());
  }
  const Vector3d margin = Vector3d::Constant(config.workspace_margin_m);
  return {box_W.min() - margin, box_W.max() + margin};
}

VoxelSpace::VoxelSpace(const VoxelSpaceConfig& config)
    : config_(config), surroundings_{{config.surroundings_voxel_m, OneVoxel(config)}, {}} {
  surroundings_.leaps.Refresh(surroundings_.grid);
}

VoxelSpace::VoxelSpace(const VoxelSpaceConfig& config, const AlignedBox3d& workspace_W)
    : VoxelSpace(config) {
  workspace_.emplace(Layer{{config.voxel_m, workspace_W}, {}});
  workspace_->leaps.Refresh(workspace_->grid);
}

template <class Change>
void VoxelSpace::ChangeGrids(const AlignedBox3d& box_W, Change change) {
  if (box_W.sizes().minCoeff() > 0.0) surroundings_.grid.Cover(box_W);
  change(&surroundings_.grid);
  surroundings_.leaps.Refresh(surroundings_.grid);
  if (!workspace_) return;
  change(&workspace_->grid);
  workspace_->leaps.Refresh(workspace_->grid);
}

void VoxelSpace::Insert(const cv::Mat& depth, const geometry::CameraModel& camera, const Pose& X_WC,
                        int stride) {
  if (!IsValid(X_WC)) {
    Throw<InvalidArgument>("voxel space: the camera pose X_WC is not finite and rigid");
  }
  DepthUpdate update;
  update.model.hit_probability = config_.hit_probability;
  update.model.miss_probability = config_.miss_probability;
  update.max_range_m = config_.max_range_m;
  update.no_return = config_.no_return_is_free ? NoReturn::kFreeToRange : NoReturn::kNothing;
  update.stride = stride;
  const Vector3d reach = Vector3d::Constant(config_.max_range_m);
  ChangeGrids({X_WC.translation() - reach, X_WC.translation() + reach},
              [&](BrickGrid* grid) { EnterDepth(depth, camera, X_WC, update, grid); });
}

void VoxelSpace::MarkOccupied(const std::vector<Vector3d>& points_W) {
  AlignedBox3d box_W;
  for (const Vector3d& p_WQ : points_W) {
    if (!p_WQ.allFinite()) {
      Throw<InvalidArgument>("voxel space: the point ({}, {}, {}) m is not finite", p_WQ.x(),
                             p_WQ.y(), p_WQ.z());
    }
    box_W.extend(p_WQ);
  }
  if (points_W.empty()) return;
  const Vector3d voxel = Vector3d::Constant(config_.surroundings_voxel_m);
  ChangeGrids({box_W.min() - voxel, box_W.max() + voxel},
              [&](BrickGrid* grid) { grid->SetPoints(points_W, kSurelyOccupied); });
}

void VoxelSpace::ClearBox(const AlignedBox3d& box_W) {
  CheckBox(box_W, "the box to clear");
  ChangeGrids(box_W, [&](BrickGrid* grid) { grid->Fill(box_W, kSurelyFree); });
}

void VoxelSpace::RemoveRegion(const AlignedBox3d& box_W) {
  CheckBox(box_W, "the region to remove");
  ChangeGrids(AlignedBox3d(), [&](BrickGrid* grid) { grid->Forget(box_W); });
}

void VoxelSpace::Place(int id, const geometry::Mesh& mesh, const Pose& X_WM) {
  const auto known = standing_.find(id);
  if (known != standing_.end() && known->second.X_WM.isApprox(X_WM, 0.0)) return;
  Standing standing{X_WM, {}, SolidVoxels(mesh, X_WM, config_.surroundings_voxel_m)};
  if (workspace_) standing.workspace = SolidVoxels(mesh, X_WM, config_.voxel_m);
  const Standing before = known == standing_.end() ? Standing{} : std::move(known->second);
  standing_[id] = std::move(standing);
  ReplaceStanding(before);
}

void VoxelSpace::TakeAway(int id) {
  const auto known = standing_.find(id);
  if (known == standing_.end()) return;
  const Standing gone = std::move(known->second);
  standing_.erase(known);
  ReplaceStanding(gone);
}

/// Takes away what stood there and sets what stands there now: models may overlap.
void VoxelSpace::ReplaceStanding(const Standing& gone) {
  AlignedBox3d box_W;
  for (const auto& [id, standing] : standing_) {
    for (const VoxelKey& key : standing.surroundings) {
      box_W.extend(surroundings_.grid.CenterOf(key));
    }
  }
  if (!box_W.isEmpty()) {
    const Vector3d voxel = Vector3d::Constant(config_.surroundings_voxel_m);
    box_W = AlignedBox3d(box_W.min() - voxel, box_W.max() + voxel);
  }
  ChangeGrids(box_W, [&](BrickGrid* grid) {
    const auto keys_of = [&](const Standing& standing) -> const std::vector<VoxelKey>& {
      return grid == &surroundings_.grid ? standing.surroundings : standing.workspace;
    };
    grid->SetStanding(keys_of(gone), false);
    for (const auto& [id, standing] : standing_) grid->SetStanding(keys_of(standing), true);
  });
}

const BrickGrid& VoxelSpace::GridAt(const Vector3d& p_WQ) const {
  return workspace_ && workspace_->grid.Contains(p_WQ) ? workspace_->grid : surroundings_.grid;
}

Occupancy VoxelSpace::At(const Vector3d& p_WQ) const { return GridAt(p_WQ).At(p_WQ); }

std::optional<double> VoxelSpace::ProbabilityAt(const Vector3d& p_WQ) const {
  return GridAt(p_WQ).ProbabilityAt(p_WQ);
}

bool VoxelSpace::Follow(const Layer& layer, const Vector3d& p_WA, const Vector3d& p_WB,
                        Passage* passage) {
  return Follow(layer, p_WA, p_WB, CastRayThroughUnknown(layer.grid, layer.leaps, p_WA, p_WB),
                passage);
}

/// Adds what the line from A to B, which ends so, meets of one layer. Out of its grid all is
/// unknown. True when it is blocked.
bool VoxelSpace::Follow(const Layer& layer, const Vector3d& p_WA, const Vector3d& p_WB,
                        const RayEnd& end, Passage* passage) {
  const auto [enter, leave] = ShareInside(layer.grid.box_W(), p_WA, p_WB);
  passage->blocked = end.state == Occupancy::kOccupied;
  const double outside = enter < leave ? enter + (passage->blocked ? 0.0 : 1.0 - leave) : 1.0;
  passage->unknown += (end.unknown + outside) * (p_WB - p_WA).norm();
  if (passage->blocked) passage->p_WE = p_WA + end.at * (p_WB - p_WA);
  return passage->blocked;
}

Passage VoxelSpace::Cast(const Vector3d& p_WA, const Vector3d& p_WB) const {
  Passage passage{false, p_WB, 0.0};
  const auto [enter, leave] =
      workspace_ ? ShareInside(workspace_->grid.box_W(), p_WA, p_WB) : std::pair(1.0, 0.0);
  if (!(enter < leave)) {
    Follow(surroundings_, p_WA, p_WB, &passage);
    return passage;
  }
  const Vector3d p_WEnter = p_WA + enter * (p_WB - p_WA);
  const Vector3d p_WLeave = p_WA + leave * (p_WB - p_WA);
  if (enter > 0.0 && Follow(surroundings_, p_WA, p_WEnter, &passage)) return passage;
  if (Follow(*workspace_, p_WEnter, p_WLeave, &passage)) return passage;
  if (leave < 1.0) Follow(surroundings_, p_WLeave, p_WB, &passage);
  return passage;
}

std::vector<Passage> VoxelSpace::Cast(const RayFan& fan) const {
  const Vector3d p_WC = fan.X_WC.translation();
  const auto direction_W = [&](int i) -> Vector3d {
    const Eigen::Vector2i at(i % fan.size.x(), i / fan.size.x());
    return fan.X_WC.linear() * fan.camera.Ray(fan.first.x() + at.x(), fan.first.y() + at.y());
  };
  // Those rays that end in the workspace are cast side by side: up to it, then through it.
  RayFan before = fan;
  RayFan within = fan;
  for (int i = 0; i < static_cast<int>(fan.depth.size()); ++i) {
    const Vector3d p_WB = p_WC + fan.depth[i] * direction_W(i);
    const auto [enter, leave] =
        workspace_ ? ShareInside(workspace_->grid.box_W(), p_WC, p_WB) : std::pair(1.0, 0.0);
    const bool ends_within = enter < leave && !(leave < 1.0);
    before.depth[i] = ends_within ? enter * fan.depth[i] : 0.0;
    within.depth[i] = ends_within ? fan.depth[i] : 0.0;
  }
  const std::vector<RayEnd> entries =
      CastFanThroughUnknown(surroundings_.grid, surroundings_.leaps, before);
  std::vector<RayEnd> ends(fan.depth.size());
  if (workspace_) ends = CastFanThroughUnknown(workspace_->grid, workspace_->leaps, within);

  std::vector<Passage> passages;
  passages.reserve(fan.depth.size());
  for (int i = 0; i < static_cast<int>(fan.depth.size()); ++i) {
    const Vector3d way_W = direction_W(i);
    const Vector3d p_WB = p_WC + fan.depth[i] * way_W;
    Passage& passage = passages.emplace_back(Passage{false, p_WB, 0.0});
    if (!(fan.depth[i] > 0.0)) continue;
    if (!(within.depth[i] > 0.0)) {
      passage = Cast(p_WC, p_WB);
      continue;
    }
    if (const double depth = before.depth[i]; depth > 0.0) {
      RayEnd entry = entries[i];  // a share of the way there is its unit
      entry.at /= depth;
      entry.unknown /= depth;
      if (Follow(surroundings_, p_WC, p_WC + depth * way_W, entry, &passage)) continue;
    }
    passage.unknown += ends[i].unknown * way_W.norm();
    passage.blocked = ends[i].state == Occupancy::kOccupied;
    if (passage.blocked) passage.p_WE = p_WC + ends[i].at * way_W;
  }
  return passages;
}

double VoxelSpace::LikelyFreeShare(const std::vector<Vector3d>& points_W) const {
  if (points_W.empty()) return 0.0;
  const auto likely_free = std::count_if(points_W.begin(), points_W.end(), [&](const Vector3d& p) {
    return ProbabilityAt(p).value_or(1.0) < config_.likely_free_below;
  });
  return static_cast<double>(likely_free) / static_cast<double>(points_W.size());
}

}  // namespace secondlook::world
