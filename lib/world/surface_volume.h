#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/geometry/mesh.h"
#include "lib/world/range_scan.h"
#include "lib/world/scan_patches.h"

namespace secondlook::world {

struct SurfaceConfig {
  double voxel_m{0.003};      ///< Edge of a voxel; not under the distance between a scan's points.
  double before_voxels{3.0};  ///< So far in front of a surface its distance is kept…
  double behind_voxels{2.0};  ///< …and behind it, where it counts less the farther.
  double max_incidence_deg{75.0};  ///< What is seen flatter is left out.
  int min_points{2};               ///< A voxel that fewer points speak of is not measured.
  double density_voxels{3.0};      ///< Radius of the sphere in which neighbours are counted.

  template <class A>
  void Serialize(A* a) {
    a->Visit("voxel_m", &voxel_m);
    a->Visit("before_voxels", &before_voxels);
    a->Visit("behind_voxels", &behind_voxels);
    a->Visit("max_incidence_deg", &max_incidence_deg);
    a->Visit("min_points", &min_points);
    a->Visit("density_voxels", &density_voxels);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// The part of a surface that was measured, in W. Its borders are where measuring ended.
struct PartialMesh {
  geometry::Mesh mesh;                   ///< With vertex colours when the scans had them.
  std::vector<Eigen::Vector3f> normals;  ///< Of each vertex, unit, outward.
  /// Of each vertex, relative point density in [0, 1] (Kriegel 2013, III-A): how many points lie
  /// within a sphere around it, of the most that the reduction to one a voxel leaves there.
  std::vector<float> density;
};

/// A surface fused from scans: a truncated signed distance field (Curless and Levoy 1996) in sparse
/// voxels (OpenVDB). The distance that a point tells a voxel is that from the plane of the point's
/// patch; it counts by how upright and how exactly the point was measured. Points are in W [m].
/// Threading: Extract() from any number of threads; nothing else at the same time.
class SurfaceVolume {
 public:
  /// Empty; only what lies in `box_W` is kept.
  /// @throws ConfigError when `config` is not valid, InvalidArgument for a box that is empty or not
  /// finite.
  SurfaceVolume(const SurfaceConfig& config, const Eigen::AlignedBox3d& box_W);
  ~SurfaceVolume();
  SurfaceVolume(SurfaceVolume&&) noexcept;
  SurfaceVolume& operator=(SurfaceVolume&&) noexcept;

  const SurfaceConfig& config() const { return config_; }
  const Eigen::AlignedBox3d& box_W() const { return box_W_; }

  /// The edge of the patches that scans are cut into [m].
  double patch() const { return 2.0 * config_.voxel_m; }

  /// Enters the scan, cut into `patches`. Returns how many of its points were used.
  /// @throws InvalidArgument as Check(), or when `patches` are not of this scan.
  int Integrate(const RangeScan& scan, const ScanPatches& patches);
  int Integrate(const RangeScan& scan) { return Integrate(scan, CutIntoPatches(scan, patch())); }

  /// The surface where all of a cell's corners are measured and their distances change sign
  /// (surface nets, Gibson 1998: a vertex a cell). Nothing is closed or smoothed. The same scans in
  /// the same order give the same mesh.
  PartialMesh Extract() const;

  /// Voxels that were measured.
  int size() const;

 private:
  struct Storage;
  SurfaceConfig config_;
  Eigen::AlignedBox3d box_W_;
  std::unique_ptr<Storage> storage_;
};

}  // namespace secondlook::world
