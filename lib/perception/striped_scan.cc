#include "lib/perception/striped_scan.h"

#include <cmath>
#include <vector>

#include "lib/common/error.h"

namespace secondlook::perception {

world::RangeScan StripedScan(std::span<const hal::ScanLine> lines, const hal::StriperInfo& striper,
                             const PoseHistory& X_WL, const LaserPrecision& precision) {
  std::vector<Eigen::Vector3d> rays_L;
  for (int i = 0; i < striper.points; ++i) rays_L.push_back(striper.Ray(i));
  world::RangeScan scan;
  scan.position_sigma = precision.position_sigma;
  scan.rotation_sigma = precision.rotation_sigma;
  for (const hal::ScanLine& line : lines) {
    if (line.ranges.size() != rays_L.size()) {
      Throw<InvalidArgument>("striper '{}': line {} has {} ranges for {} rays", striper.name,
                             line.sequence, line.ranges.size(), rays_L.size());
    }
    const Pose X = X_WL.At(line.time);
    for (std::size_t i = 0; i < rays_L.size(); ++i) {
      if (std::isnan(line.ranges[i])) continue;
      scan.points_W.emplace_back(X * (line.ranges[i] * rays_L[i]));
    }
    scan.lines.push_back({X.translation(), static_cast<int>(scan.points_W.size())});
  }
  scan.sigmas.assign(scan.points_W.size(), static_cast<float>(striper.range_sigma));
  return scan;
}

}  // namespace secondlook::perception
