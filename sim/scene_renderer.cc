#include "sim/scene_renderer.h"

namespace secondlook::sim {
namespace {

constexpr int kSegments = 48;  // of a moving obstacle

}  // namespace

SceneRenderer::SceneRenderer(const World& world, const geometry::CameraModel& model)
    : renderer_(model, {world.scene().lights, world.scene().ambient}) {
  for (const Fixture& fixture : world.fixtures()) {
    fixed_.push_back({renderer_.AddMesh(fixture.mesh), fixture.X_WM, fixture.id});
  }
  for (const MovingObstacle& obstacle : world.scene().moving_obstacles) {
    const geometry::Mesh mesh = geometry::MakeCylinder(obstacle.radius, obstacle.height, kSegments,
                                                       obstacle.color.cast<float>());
    moving_.push_back({renderer_.AddMesh(mesh), Pose::Identity(), kMovingObstacleId});
  }
}

Render SceneRenderer::Draw(const Pose& X_WC, const WorldState& state) {
  std::vector<Instance> instances = fixed_;
  for (std::size_t i = 0; i < moving_.size(); ++i) {
    instances.push_back(moving_[i]);
    instances.back().X_WM.translation().head<2>() = state.obstacles_W[i];
  }
  return renderer_.Draw(X_WC, instances);
}

Render SceneRenderer::DrawAlone(const Pose& X_WC, int index) {
  for (const Instance& instance : fixed_) {
    if (instance.id == kFirstObjectId + index) return renderer_.Draw(X_WC, {instance});
  }
  return renderer_.Draw(X_WC, {});
}

}  // namespace secondlook::sim
