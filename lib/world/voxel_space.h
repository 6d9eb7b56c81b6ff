#pragma once

#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/geometry/mesh.h"
#include "lib/world/bayes_update.h"
#include "lib/world/brick_grid.h"
#include "lib/world/leap_field.h"
#include "lib/world/ray_cast.h"
#include "lib/world/support_plane.h"

namespace secondlook::world {

struct VoxelSpaceConfig {
  double voxel_m{0.01};               ///< Edge of a voxel in the workspace.
  double surroundings_voxel_m{0.02};  ///< … and of the coarser ones everywhere.
  double max_range_m{3.0};         ///< Rays are cut off there; what they hit beyond is not entered.
  bool no_return_is_free{false};   ///< A pixel without a return is free up to the range.
  double hit_probability{0.7};     ///< p(occupied | a ray ends in the voxel), in (0.5, 1).
  double miss_probability{0.4};    ///< p(occupied | a ray passes through it), in (0, 0.5).
  double likely_free_below{0.25};  ///< p_v under which a voxel is likely free (Kriegel, III-E).
  double workspace_height_m{0.6};  ///< Of the workspace above its support plane.
  double workspace_margin_m{0.1};  ///< … by which it is larger on all sides and reaches below.

  template <class A>
  void Serialize(A* a) {
    a->Visit("voxel_m", &voxel_m);
    a->Visit("surroundings_voxel_m", &surroundings_voxel_m);
    a->Visit("max_range_m", &max_range_m);
    a->Visit("no_return_is_free", &no_return_is_free);
    a->Visit("hit_probability", &hit_probability);
    a->Visit("miss_probability", &miss_probability);
    a->Visit("likely_free_below", &likely_free_below);
    a->Visit("workspace_height_m", &workspace_height_m);
    a->Visit("workspace_margin_m", &workspace_margin_m);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// The workspace above a support plane: the box around its rectangle, extruded.
Eigen::AlignedBox3d WorkspaceAbove(const SupportPlane& plane_W, const VoxelSpaceConfig& config);

/// What a straight line through the map meets.
struct Passage {
  bool blocked{};        ///< It meets an occupied voxel.
  Eigen::Vector3d p_WE;  ///< Where it enters that voxel, or the line's end [m].
  double unknown{};      ///< How much of the way to E is unknown [m].
};

/// The probabilistic voxel space (Kriegel 2013, III-A): what is known of the space around the
/// robot, for every voxel the probability that it is occupied, or that nothing was ever measured
/// there. A bounded grid of fine voxels covers the workspace above the table, coarser ones grow
/// with what the robot sees, for driving. Both take every measurement; in the workspace the fine
/// ones answer. Points are in frame W [m]. A copy is independent. Threading: queries from any
/// number of threads; nothing else at the same time.
class VoxelSpace {
 public:
  /// An empty map without a workspace. @throws ConfigError when `config` is not valid.
  explicit VoxelSpace(const VoxelSpaceConfig& config = {});
  /// An empty map with one. @throws InvalidArgument also for a box that is empty, not finite,
  /// without a volume or too large.
  VoxelSpace(const VoxelSpaceConfig& config, const Eigen::AlignedBox3d& workspace_W);

  const VoxelSpaceConfig& config() const { return config_; }
  /// Null when there is none.
  const BrickGrid* workspace() const { return workspace_ ? &workspace_->grid : nullptr; }
  const BrickGrid& surroundings() const { return surroundings_.grid; }

  /// Enters a depth image (EnterDepth).
  /// @param depth [height, width] CV_32FC1, z_C [m]; NaN, infinite or <= 0: no return.
  /// @param stride Every stride-th pixel of every stride-th row is used.
  /// @throws InvalidArgument for a depth image of another type or size than the camera's, a pose
  /// that is not rigid and finite, or a stride below 1.
  void Insert(const cv::Mat& depth, const geometry::CameraModel& camera, const Pose& X_WC,
              int stride);

  /// Makes the voxels around `points_W` occupied for sure.
  /// @throws InvalidArgument for a point that is not finite.
  void MarkOccupied(const std::vector<Eigen::Vector3d>& points_W);

  /// Makes every voxel whose centre lies in `box_W` free for sure.
  /// @throws InvalidArgument for a box that is not finite.
  void ClearBox(const Eigen::AlignedBox3d& box_W);

  /// Forgets every voxel whose centre lies in `box_W`, e.g. around an object that was moved: it is
  /// unknown again. @throws InvalidArgument for a box that is not finite.
  void RemoveRegion(const Eigen::AlignedBox3d& box_W);

  /// Lets a verified object stand in the map as its whole model: the voxels of its surface and its
  /// inside are occupied whatever was measured there. Replaces what stood there by that `id`.
  /// @throws InvalidArgument as SolidVoxels().
  void Place(int id, const geometry::Mesh& mesh, const Pose& X_WM);
  /// Takes it away again: what was measured there holds. Nothing when it does not stand there.
  void TakeAway(int id);

  /// The state of the voxel around the point. A point that is not finite is unknown.
  Occupancy At(const Eigen::Vector3d& p_WQ) const;

  /// The probability of the voxel around the point, by measurement alone; empty where none was
  /// made.
  std::optional<double> ProbabilityAt(const Eigen::Vector3d& p_WQ) const;

  /// Follows the straight line from A to B up to the first occupied voxel, the one around A
  /// included. @pre both are finite.
  Passage Cast(const Eigen::Vector3d& p_WA, const Eigen::Vector3d& p_WB) const;

  /// As Cast() from the camera along the ray of each pixel of the fan; blocked: false and no
  /// unknown for a ray that is not cast. @throws InvalidArgument as CastFan().
  std::vector<Passage> Cast(const RayFan& fan) const;

  /// The share of `points_W` that lie in a voxel that is likely free (Kriegel 2013, III-E; unknown
  /// ones are not). 0 for no points.
  double LikelyFreeShare(const std::vector<Eigen::Vector3d>& points_W) const;

 private:
  /// A grid and what its rays leap by.
  struct Layer {
    BrickGrid grid;
    LeapField leaps;
  };
  struct Standing {
    Pose X_WM{Pose::Identity()};
    std::vector<VoxelKey> workspace;
    std::vector<VoxelKey> surroundings;
  };

  static bool Follow(const Layer& layer, const Eigen::Vector3d& p_WA, const Eigen::Vector3d& p_WB,
                     Passage* passage);
  static bool Follow(const Layer& layer, const Eigen::Vector3d& p_WA, const Eigen::Vector3d& p_WB,
                     const RayEnd& end, Passage* passage);
  const BrickGrid& GridAt(const Eigen::Vector3d& p_WQ) const;
  /// Calls `change` for each grid, the surroundings grown by `box_W` before, and follows.
  template <class Change>
  void ChangeGrids(const Eigen::AlignedBox3d& box_W, Change change);
  void ReplaceStanding(const Standing& gone);

  VoxelSpaceConfig config_;
  std::optional<Layer> workspace_;
  Layer surroundings_;
  std::map<int, Standing> standing_;  ///< By the object's id.
};

}  // namespace secondlook::world
