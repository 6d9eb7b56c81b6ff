#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"

namespace octomap {
class OcTree;
}

namespace secondlook::world {

struct VoxelSpaceConfig {
  double voxel_m{0.02};            ///< Edge of a voxel.
  double max_range_m{3.0};         ///< Rays are cut off there; what they hit beyond is not entered.
  double hit_probability{0.7};     ///< p(occupied | a ray ends in the voxel), in (0.5, 1).
  double miss_probability{0.4};    ///< p(occupied | a ray passes through it), in (0, 0.5).
  double likely_free_below{0.25};  ///< p_v under which a voxel is likely free (Kriegel, III-E).

  template <class A>
  void Serialize(A* a) {
    a->Visit("voxel_m", &voxel_m);
    a->Visit("max_range_m", &max_range_m);
    a->Visit("hit_probability", &hit_probability);
    a->Visit("miss_probability", &miss_probability);
    a->Visit("likely_free_below", &likely_free_below);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// What is known of a place. Free and occupied are decided at probability 0.5.
enum class Occupancy { kFree, kOccupied, kUnknown };

/// A cube of the map in which everything has the same state.
struct Voxel {
  Eigen::Vector3d center_W;  ///< [m]
  double size{};             ///< Edge [m]: the map's voxel, or larger where neighbours agree.
  double probability{};      ///< Of being occupied.
};

/// What a straight line through the map meets.
struct Passage {
  bool blocked{};        ///< It meets an occupied voxel.
  Eigen::Vector3d p_WE;  ///< Where it enters that voxel, or the line's end [m].
  double unknown{};      ///< How much of the way to E is unknown [m].
};

/// What is known of the space around the robot: for every voxel the probability that it is
/// occupied, or that nothing was ever measured there. Points are in frame W [m]; what lies outside
/// of +-30,000 voxels is unknown and is never entered. A copy is independent.
/// Threading: queries from any number of threads; nothing else at the same time.
class VoxelSpace {
 public:
  /// An empty map. @throws ConfigError when `config` is not valid.
  explicit VoxelSpace(const VoxelSpaceConfig& config = {});
  VoxelSpace(const VoxelSpace& other);
  VoxelSpace& operator=(const VoxelSpace& other);
  VoxelSpace(VoxelSpace&&) noexcept;
  VoxelSpace& operator=(VoxelSpace&&) noexcept;
  ~VoxelSpace();

  const VoxelSpaceConfig& config() const { return config_; }

  /// Enters a depth image by ray casting: voxels in which a ray ends become more probably occupied,
  /// those it passes more probably free, each once a call however many rays there are (end points
  /// are discretised first). A pixel without a return says nothing at all.
  /// @param depth [height, width] CV_32FC1, z_C [m]; NaN or <= 0: none.
  /// @param stride Every stride-th pixel of every stride-th row is used.
  /// @throws InvalidArgument for a depth image of another type or size than the camera's, a pose
  /// that is not rigid and finite, or a stride below 1.
  void Insert(const cv::Mat& depth, const geometry::CameraModel& camera, const Pose& X_WC,
              int stride);

  /// Makes the voxels around `points_W` occupied for sure, e.g. the surface or the inside of a
  /// verified model. @throws InvalidArgument for a point that is not finite.
  void MarkOccupied(const std::vector<Eigen::Vector3d>& points_W);

  /// Makes every voxel whose centre lies in `box_W` free for sure.
  /// @throws InvalidArgument for a box that is not finite.
  void ClearBox(const Eigen::AlignedBox3d& box_W);

  /// Forgets every voxel whose centre lies in `box_W`: it is unknown again.
  /// @throws InvalidArgument for a box that is not finite.
  void RemoveRegion(const Eigen::AlignedBox3d& box_W);

  /// The state of the voxel around the point. A point that is not finite is unknown.
  Occupancy At(const Eigen::Vector3d& p_WQ) const;

  /// Follows the straight line from A to B up to the first occupied voxel, the one around A
  /// included. @pre both are finite.
  Passage Cast(const Eigen::Vector3d& p_WA, const Eigen::Vector3d& p_WB) const;

  /// The share of `points_W` that lie in a voxel that is likely free (Kriegel 2013, III-E; unknown
  /// ones are not). 0 for no points.
  double LikelyFreeShare(const std::vector<Eigen::Vector3d>& points_W) const;

  /// Calls `visitor` for every known cube, free or occupied, whose centre lies in `box_W` or that
  /// reaches into it, in an order that depends on the map's content alone.
  void Visit(const Eigen::AlignedBox3d& box_W,
             const std::function<void(const Voxel&)>& visitor) const;

  /// The occupied cubes in `box_W`, in the order of Visit().
  std::vector<Voxel> Occupied(const Eigen::AlignedBox3d& box_W) const;

  /// Writes the map as an OctoMap file: `.ot` with all probabilities, `.bt` with free and occupied
  /// alone. @throws ConfigError for another suffix or when it cannot be written.
  void Save(const std::filesystem::path& file) const;

  /// Replaces the content by that of a file that Save() or OctoMap has written.
  /// @throws ConfigError naming the file: missing, of another suffix, not an octree, or of another
  /// voxel size than the config's.
  void Load(const std::filesystem::path& file);

  /// The octree itself, for FCL. Valid until the next change of the map.
  const octomap::OcTree& octree() const;

 private:
  class Tree;
  VoxelSpaceConfig config_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace secondlook::world
