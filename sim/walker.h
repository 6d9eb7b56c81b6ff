#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "sim/scene.h"
#include "sim/surroundings.h"

namespace secondlook::sim {

/// A moving obstacle on its way to and fro. It does not run into a robot: it waits until the way is
/// free.
class Walker {
 public:
  explicit Walker(const MovingObstacle& obstacle);

  /// Walks on for `dt` [s], unless that would bring it within 5 cm of the disc `robot`.
  void Step(double dt, const Disc& robot);

  Disc disc() const { return {obstacle_.name, position_W_, obstacle_.radius}; }

 private:
  MovingObstacle obstacle_;
  Eigen::Vector2d position_W_;
  std::size_t next_{};  ///< The waypoint it walks to.
  bool forward_{true};  ///< From the first to the last.
};

}  // namespace secondlook::sim
