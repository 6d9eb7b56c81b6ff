#include "sim/surroundings.h"

#include <algorithm>

namespace secondlook::sim {

using Eigen::Vector2d;

Nearest NearestOf(const Disc& disc, const Vector2d& a, const Vector2d& b) {
  const Nearest center = NearestOfSegment(disc.center_W, disc.center_W, a, b);
  const Vector2d toward = center.point_W - disc.center_W;
  if (center.distance <= disc.radius) return {0.0, center.point_W};
  return {center.distance - disc.radius, disc.center_W + toward * (disc.radius / center.distance)};
}

Nearest Surroundings::NearestTo(const Vector2d& a, const Vector2d& b, double reach) const {
  Nearest nearest{reach, b};
  for (const Footprint& footprint : fixed) {
    const Nearest around = NearestOf(Disc{{}, footprint.center_W, footprint.bound}, a, b);
    if (around.distance >= nearest.distance) continue;
    const Nearest here = NearestOf(footprint, a, b);
    if (here.distance < nearest.distance) nearest = here;
  }
  for (const Disc& disc : moving) {
    const Nearest here = NearestOf(disc, a, b);
    if (here.distance < nearest.distance) nearest = here;
  }
  return nearest;
}

}  // namespace secondlook::sim
