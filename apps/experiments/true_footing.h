#pragma once

#include <memory>
#include <vector>

#include "lib/common/pose.h"
#include "sim/fixtures.h"

namespace secondlook::apps {

/// Tests whether an upright cylinder would touch the true meshes of a scene (FCL).
class TrueFooting {
 public:
  /// @param fixtures Of these, those that a base can run into.
  explicit TrueFooting(const std::vector<sim::Fixture>& fixtures);
  ~TrueFooting();

  /// True when nothing touches the cylinder about the z axis at `p_W` of that `radius`, from
  /// `bottom` to `top` above the floor [m].
  bool Free(const Eigen::Vector2d& p_W, double radius, double bottom, double top) const;

 private:
  struct Meshes;
  std::unique_ptr<Meshes> meshes_;
};

}  // namespace secondlook::apps
