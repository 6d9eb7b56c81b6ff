#include "sim/surroundings.h"

#include <algorithm>
#include <limits>

namespace secondlook::sim {

using Eigen::Vector2d;

Nearest NearestOf(const Disc& disc, const Vector2d& a, const Vector2d& b) {
  const Nearest center = NearestOfSegment(disc.center_W, disc.center_W, a, b);
  const Vector2d toward = center.point_W - disc.center_W;
  if (center.distance <= disc.radius) return {0.0, center.point_W};
  return {center.distance - disc.radius, disc.center_W + toward * (disc.radius / center.distance)};
}

std::optional<Vector2d> Surroundings::InTheWay(const Vector2d& a, const Vector2d& b, double reach,
                                               double berth) const {
  constexpr double kNearer = 1e-6;  // [m]
  std::optional<Vector2d> point;
  double nearest = std::numeric_limits<double>::infinity();
  const auto consider = [&](const auto& thing, double touch) {
    const Nearest ahead = NearestOf(thing, a, b);
    if (ahead.distance >= std::min(touch, nearest)) return;
    if (ahead.distance > NearestOf(thing, a, a).distance - kNearer) return;
    nearest = ahead.distance;
    point = ahead.point_W;
  };
  for (const Footprint& footprint : fixed) {
    const Disc around{{}, footprint.center_W, footprint.bound};
    if (NearestOf(around, a, b).distance < reach) consider(footprint, reach);
  }
  for (const Disc& disc : moving) consider(disc, reach + berth);
  return point;
}

}  // namespace secondlook::sim
