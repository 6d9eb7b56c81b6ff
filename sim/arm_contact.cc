#include "sim/arm_contact.h"

#include <algorithm>
#include <utility>

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>

#include "lib/geometry/collision_shape.h"

namespace secondlook::sim {

struct ArmContact::Shapes {
  struct Thing {
    std::string name;
    fcl::CollisionObjectd object;
  };
  struct Part {
    int link;
    Pose X_LS;
    std::shared_ptr<fcl::CollisionGeometryd> geometry;
  };
  std::vector<Thing> things;
  std::vector<Part> parts;
};

ArmContact::ArmContact(const std::vector<Fixture>& fixtures, const kinematics::Chain& chain)
    : shapes_(std::make_unique<Shapes>()) {
  for (const Fixture& fixture : fixtures) {
    fcl::CollisionObjectd object(geometry::MakeCollisionSurface(fixture.mesh), fixture.X_WM);
    object.computeAABB();
    shapes_->things.push_back({fixture.name, std::move(object)});
  }
  const std::vector<kinematics::Link>& links = chain.model().links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (!chain.Moves(static_cast<int>(i))) continue;
    for (const geometry::PlacedShape& part : links[i].body) {
      shapes_->parts.push_back(
          {static_cast<int>(i), part.X_AS, geometry::MakeCollisionShape(part.shape, 0.0)});
    }
  }
}

ArmContact::~ArmContact() = default;

std::vector<ArmTouch> ArmContact::Touches(const Pose& X_WB, const std::vector<Pose>& X_BL) const {
  std::vector<fcl::CollisionObjectd> parts;
  for (const Shapes::Part& part : shapes_->parts) {
    parts.emplace_back(part.geometry, X_WB * X_BL[part.link] * part.X_LS);
    parts.back().computeAABB();
  }
  std::vector<ArmTouch> touches;
  const fcl::CollisionRequestd request(1, true);
  for (const Shapes::Thing& thing : shapes_->things) {
    for (const fcl::CollisionObjectd& part : parts) {
      if (!thing.object.getAABB().overlap(part.getAABB())) continue;
      fcl::CollisionResultd result;
      if (fcl::collide(&thing.object, &part, request, result) == 0) continue;
      touches.push_back({thing.name, result.getContact(0).pos});
      break;
    }
  }
  return touches;
}

}  // namespace secondlook::sim
