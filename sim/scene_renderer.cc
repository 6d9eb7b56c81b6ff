#include "sim/scene_renderer.h"

namespace secondlook::sim {
namespace {

constexpr int kSegments = 48;           // of a moving obstacle
constexpr double kShadowMargin = 0.25;  // [m] around the table

Lighting LightingOf(const Scene& scene) {
  const Table& table = scene.table;
  return {scene.lights,
          scene.ambient,
          {table.position.x(), table.position.y(), table.height},
          table.size.norm() / 2 + kShadowMargin};
}

}  // namespace

SceneRenderer::SceneRenderer(const World& world, const geometry::CameraModel& model)
    : renderer_(model, LightingOf(world.scene())) {
  // Objects first, floor last: what is hidden then need not be shaded.
  const std::vector<Fixture>& fixtures = world.fixtures();
  for (auto fixture = fixtures.rbegin(); fixture != fixtures.rend(); ++fixture) {
    fixed_.push_back({renderer_.AddMesh(fixture->mesh), fixture->X_WM, fixture->id});
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
