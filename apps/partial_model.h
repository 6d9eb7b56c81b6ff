#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "apps/modelling_config.h"
#include "lib/perception/coverage.h"
#include "lib/world/observation.h"
#include "lib/world/range_scan.h"
#include "lib/world/support_plane.h"
#include "lib/world/surface_volume.h"

namespace secondlook::apps {

/// What a view that was registered to the map measured in `box_W`, as a scan with colours.
/// @param config How well the view is registered.
world::RangeScan ScanOf(const world::Observation& view, const Eigen::AlignedBox3d& box_W,
                        const ModellingConfig& config);

/// The surface of one thing that stands on a support, as the scans so far show it.
class PartialModel {
 public:
  /// @param box_W Holds the thing, what is hidden of it included, and a piece of what is around.
  PartialModel(const ModellingConfig& config, const Eigen::AlignedBox3d& box_W,
               const world::SupportPlane& plane_W);

  const Eigen::AlignedBox3d& box_W() const { return volume_.box_W(); }

  /// Registers a scan to what is there and fuses it. Returns why it was refused, and changes
  /// nothing then; empty when it was fused.
  std::string Add(world::RangeScan scan);

  /// Says which of the surface is the thing's: what is nearer to `own_W`, points of it, than to
  /// `others_W`, and near enough.
  void Separate(const std::vector<Eigen::Vector3d>& own_W,
                const std::vector<Eigen::Vector3d>& others_W);

  /// The thing's, after Separate(). Vertex normals, colours and density as fused.
  const world::PartialMesh& surface() const { return surface_; }
  const perception::Coverage& coverage() const { return coverage_; }
  /// Scans that it rests on.
  int scans() const { return scans_; }

 private:
  ModellingConfig config_;
  world::SupportPlane plane_W_;
  world::SurfaceVolume volume_;
  world::PartialMesh all_;  ///< With the support and what else is in the box.
  world::PartialMesh surface_;
  perception::Coverage coverage_;
  int scans_{};
};

/// A surface as a mesh that stands: in M, whose origin is `p_WM` on the support and whose axes are
/// W's. Its rim next to the support is drawn down to it.
geometry::Mesh StandingMesh(const world::PartialMesh& surface, const Eigen::Vector3d& p_WM,
                            double rim);

}  // namespace secondlook::apps
