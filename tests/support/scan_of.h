#pragma once

#include "lib/common/pose.h"
#include "lib/common/rng.h"
#include "lib/geometry/mesh.h"
#include "lib/geometry/ray_caster.h"
#include "lib/world/range_scan.h"

namespace secondlook::tests {

/// What a range sensor at `p_WS` that looks at `p_WT` measures of `mesh_W`: `count` x `count` rays,
/// `spacing` apart at T [m], ranges off by `sigma` [m].
inline world::RangeScan ScanOf(const geometry::Mesh& mesh_W, const Eigen::Vector3d& p_WS,
                               const Eigen::Vector3d& p_WT, int count, double spacing, double sigma,
                               Rng* rng) {
  const Pose X_WS = LookAt(p_WS, p_WT);
  const double distance = (p_WT - p_WS).norm();
  std::vector<geometry::Ray> rays;
  for (int v = 0; v < count; ++v) {
    for (int u = 0; u < count; ++u) {
      const Eigen::Vector3d way_S((u - 0.5 * (count - 1)) * spacing,
                                  (v - 0.5 * (count - 1)) * spacing, distance);
      rays.push_back({p_WS.cast<float>(), (X_WS.linear() * way_S.normalized()).cast<float>()});
    }
  }
  world::RangeScan scan;
  const geometry::RayCaster caster(mesh_W);
  const std::vector<geometry::RayHit> hits = caster.Cast(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].triangle < 0) continue;
    const double range = hits[i].distance + (sigma > 0.0 ? rng->Gaussian(sigma) : 0.0);
    scan.points_W.emplace_back(p_WS + range * rays[i].direction_M.cast<double>());
  }
  scan.sigmas.assign(scan.points_W.size(), static_cast<float>(std::max(sigma, 1e-4)));
  scan.lines = {{p_WS, static_cast<int>(scan.points_W.size())}};
  return scan;
}

}  // namespace secondlook::tests
