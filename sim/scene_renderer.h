#pragma once

#include <vector>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "sim/render.h"
#include "sim/renderer.h"
#include "sim/world.h"

namespace secondlook::sim {

/// Draws the whole world through one camera model, the robot's own body included when it has an
/// arm. Ids are those of sim/fixtures.h.
class SceneRenderer {
 public:
  /// `world` must outlive this.
  SceneRenderer(const World& world, const geometry::CameraModel& model);

  /// What is seen from `X_WC` when the moving obstacles and the robot are as in `state`.
  Render Draw(const Pose& X_WC, const WorldState& state);

  /// The same with nothing in the world but object `index` of the scene.
  Render DrawAlone(const Pose& X_WC, int index);

 private:
  const World& world_;
  Renderer renderer_;
  std::vector<Instance> fixed_;
  std::vector<Instance> moving_;
  std::vector<Instance> body_;  // of the robot
};

}  // namespace secondlook::sim
