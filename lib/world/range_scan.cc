#include "lib/world/range_scan.h"

#include "lib/common/error.h"

namespace secondlook::world {

void Check(const RangeScan& scan) {
  const std::size_t points = scan.points_W.size();
  if (scan.sigmas.size() != points) {
    Throw<InvalidArgument>("range scan: {} sigmas for {} points", scan.sigmas.size(), points);
  }
  if (!scan.colors.empty() && scan.colors.size() != points) {
    Throw<InvalidArgument>("range scan: {} colours for {} points; none or one for each is wanted",
                           scan.colors.size(), points);
  }
  for (std::size_t i = 0; i < points; ++i) {
    if (!scan.points_W[i].allFinite() || !(scan.sigmas[i] > 0.0F)) {
      const Eigen::Vector3d& p = scan.points_W[i];
      Throw<InvalidArgument>(
          "range scan: point {} at ({}, {}, {}) m with a sigma of {} m; it must be finite and its "
          "sigma positive",
          i, p.x(), p.y(), p.z(), scan.sigmas[i]);
    }
  }
  int end = 0;
  for (std::size_t i = 0; i < scan.lines.size(); ++i) {
    const RangeLine& line = scan.lines[i];
    if (!line.p_WS.allFinite() || line.end < end) {
      Throw<InvalidArgument>(
          "range scan: line {} is measured from ({}, {}, {}) m and ends at point {}, the one "
          "before at {}; the place must be finite and the ends must not decrease",
          i, line.p_WS.x(), line.p_WS.y(), line.p_WS.z(), line.end, end);
    }
    end = line.end;
  }
  if (static_cast<std::size_t>(end) != points) {
    Throw<InvalidArgument>("range scan: its lines end at point {}, but it has {}", end, points);
  }
  if (!(scan.position_sigma >= 0.0) || !(scan.rotation_sigma >= 0.0)) {
    Throw<InvalidArgument>("range scan: its poses have sigmas of {} m and {} rad",
                           scan.position_sigma, scan.rotation_sigma);
  }
}

}  // namespace secondlook::world
