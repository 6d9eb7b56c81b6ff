#pragma once

#include <optional>
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

  /// The point [m] of the nearest thing that is in the way of a disc of radius `reach` [m] from `a`
  /// to `b` (in W): the disc would touch it and comes nearer to it than at `a`; what is beside or
  /// behind is not in the way. From what moves it keeps `berth` [m] more. Empty: the way is free.
  std::optional<Eigen::Vector2d> InTheWay(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                          double reach, double berth) const;
};

/// The nearest point of `disc` to the segment from `a` to `b`, all in W.
Nearest NearestOf(const Disc& disc, const Eigen::Vector2d& a, const Eigen::Vector2d& b);

}  // namespace secondlook::sim
