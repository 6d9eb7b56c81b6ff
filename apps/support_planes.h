#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/perception/segment.h"
#include "lib/world/scene_belief.h"

namespace secondlook::apps {

/// The support planes of a scene, each growing with what the views show of it.
class SupportPlanes {
 public:
  /// Enters what a view, taken from X_WC, shows: of the plane that the mission is about
  /// (`belief->plane_W`, defined by the first view), and of the others (`belief->further_W`).
  void Grow(const perception::Segmentation& seen, const Pose& X_WC, world::SceneBelief* belief);

 private:
  void GrowFurther(const perception::FurtherSupport& seen, const Pose& X_WC,
                   std::vector<world::SupportPlane>* planes_W);

  std::vector<Eigen::Vector3d> points_W_;
  std::vector<std::vector<Eigen::Vector3d>> further_points_W_;  // by plane of belief.further_W
};

}  // namespace secondlook::apps
