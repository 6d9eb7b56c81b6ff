#include "apps/experiments/true_footing.h"

#include <fcl/geometry/shape/cylinder.h>
#include <fcl/narrowphase/collision.h>

#include "lib/geometry/collision_shape.h"

namespace secondlook::apps {

struct TrueFooting::Meshes {
  struct Placed {
    std::shared_ptr<fcl::CollisionGeometryd> surface;
    Pose X_WM;
  };
  std::vector<Placed> placed;
};

TrueFooting::TrueFooting(const std::vector<sim::Fixture>& fixtures)
    : meshes_(std::make_unique<Meshes>()) {
  for (const sim::Fixture& fixture : fixtures) {
    if (!fixture.in_the_way) continue;
    meshes_->placed.push_back({geometry::MakeCollisionSurface(fixture.mesh), fixture.X_WM});
  }
}

TrueFooting::~TrueFooting() = default;

bool TrueFooting::Free(const Eigen::Vector2d& p_W, double radius, double bottom, double top) const {
  const fcl::Cylinderd cylinder(radius, top - bottom);
  Pose X_WF = Pose::Identity();
  X_WF.translation() << p_W.x(), p_W.y(), 0.5 * (bottom + top);
  const fcl::CollisionRequestd request(1, false);
  for (const Meshes::Placed& mesh : meshes_->placed) {
    fcl::CollisionResultd result;
    if (fcl::collide(mesh.surface.get(), mesh.X_WM, &cylinder, X_WF, request, result) > 0) {
      return false;
    }
  }
  return true;
}

}  // namespace secondlook::apps
