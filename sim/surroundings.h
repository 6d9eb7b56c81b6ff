#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "sim/footprint.h"

namespace secondlook::sim {

/// A moving obstacle at one instant: a disc on the floor.
struct Disc {
  std::string name;
  Eigen::Vector2d center_W{0.0, 0.0};  ///< [m]
  double radius{};                     ///< [m]
};

/// All that the base can run into, at one instant.
struct Surroundings {
  std::vector<Footprint> fixed;
  std::vector<Disc> moving;

  /// The nearest thing to the segment from `a` to `b` (in W) that is nearer than `reach` [m];
  /// otherwise the distance is `reach`.
  Nearest NearestTo(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double reach) const;
};

/// The nearest point of `disc` to the segment from `a` to `b`, all in W.
Nearest NearestOf(const Disc& disc, const Eigen::Vector2d& a, const Eigen::Vector2d& b);

}  // namespace secondlook::sim
