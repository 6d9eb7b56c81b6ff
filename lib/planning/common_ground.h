#pragma once

#include <vector>

#include "lib/common/pose.h"
#include "lib/hal/camera.h"
#include "lib/perception/register_view.h"

namespace secondlook::planning {

/// What a view from somewhere else would share with the map, so that it can be registered to it.
class CommonGround {
 public:
  /// @param reference_W What views are registered to, in W, which is z up.
  /// @param config Of the registration.
  CommonGround(const std::vector<perception::SurfacePoint>& reference_W,
               const perception::RegisterConfig& config);

  /// How many pairs of upright surface a view from `X_WC` would have in common with the map, if
  /// nothing new stood in between. A level surface holds height and tilt alone, so it is not
  /// counted: of a thing by itself, a view from behind shares nothing with one from the front.
  /// Not counted on once there are as many as registration wants.
  double Pairs(const Pose& X_WC, const hal::CameraInfo& camera) const;

  /// The chance that a view with so many pairs can be registered: 1 with as many as registration
  /// wants, less in proportion.
  double ChanceOf(double pairs) const;
  /// The same of a view from `X_WC`.
  double Chance(const Pose& X_WC, const hal::CameraInfo& camera) const {
    return ChanceOf(Pairs(X_WC, camera));
  }

 private:
  std::vector<perception::SurfacePoint> upright_W_;
  double pairs_a_point_{};
  int min_pairs_{};
};

}  // namespace secondlook::planning
