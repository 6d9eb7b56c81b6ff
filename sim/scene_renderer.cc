#include "sim/scene_renderer.h"

namespace secondlook::sim {
namespace {

constexpr int kSegments = 48;           // of a moving obstacle
constexpr double kShadowMargin = 0.25;  // [m] around the table
const Eigen::Vector3f kBodyColor(0.72F, 0.72F, 0.74F);

Lighting LightingOf(const Scene& scene) {
  const Table& table = scene.table;
  return {scene.lights,
          scene.ambient,
          {table.position.x(), table.position.y(), table.height},
          table.size.norm() / 2 + kShadowMargin};
}

}  // namespace

SceneRenderer::SceneRenderer(const World& world, const geometry::CameraModel& model)
    : world_(world), renderer_(model, LightingOf(world.scene())) {
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
  if (world.arm() == nullptr) return;
  for (const kinematics::Link& link : world.arm()->chain().model().links) {
    for (const geometry::PlacedShape& part : link.body) {
      const geometry::Mesh mesh = geometry::MakeMesh(part.shape, kSegments, kBodyColor);
      body_.push_back({renderer_.AddMesh(mesh), Pose::Identity(), kOwnBodyId});
    }
  }
}

Render SceneRenderer::Draw(const Pose& X_WC, const WorldState& state) {
  std::vector<Instance> instances = fixed_;
  for (std::size_t i = 0; i < moving_.size(); ++i) {
    instances.push_back(moving_[i]);
    instances.back().X_WM.translation().head<2>() = state.obstacles_W[i];
  }
  if (!body_.empty()) {
    const auto placed = world_.arm()->chain().Body(state.arm);
    for (std::size_t i = 0; i < body_.size(); ++i) {
      instances.push_back(body_[i]);
      instances.back().X_WM = ToPose(state.X_WB) * placed[i].X_AS;
    }
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
