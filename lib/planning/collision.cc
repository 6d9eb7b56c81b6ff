#include "lib/planning/collision.h"

#include <algorithm>
#include <cmath>

#include <fcl/fcl.h>
#include <octomap/OcTree.h>

#include "lib/common/error.h"
#include "lib/geometry/collision_shape.h"
#include "lib/world/octomap_exchange.h"

namespace secondlook::planning {
namespace {

/// A solid of FCL at a place.
struct Solid {
  std::shared_ptr<fcl::CollisionGeometryd> geometry;
  Pose X_WS;
};

/// The first contact of the two, if any.
std::optional<Eigen::Vector3d> FirstContact(const fcl::CollisionGeometryd& a, const Pose& X_WA,
                                            const fcl::CollisionGeometryd& b, const Pose& X_WB) {
  const fcl::CollisionRequestd request(1, true);
  fcl::CollisionResultd result;
  if (fcl::collide(&a, X_WA, &b, X_WB, request, result) == 0) return std::nullopt;
  return result.getContact(0).pos;
}

}  // namespace

struct CollisionChecker::Shapes {
  fcl::Cylinderd footprint;
  double middle;                    ///< Height of the footprint's centre [m].
  std::optional<fcl::OcTreed> map;  ///< Empty: nothing is known yet.
  std::vector<Solid> solids;
};

CollisionChecker::CollisionChecker(const world::VoxelSpace& space,
                                   const std::vector<world::SupportPlane>& supports_W,
                                   const hal::BaseInfo& base, const CostMapConfig& config) {
  config.Validate();
  const double height = base.height - config.min_height_m;
  if (!(base.radius > 0.0) || !(height > 0.0) || !std::isfinite(base.radius + height)) {
    Throw<InvalidArgument>("collision: base '{}' of radius {} m and height {} m", base.name,
                           base.radius, base.height);
  }
  shapes_ = std::make_unique<Shapes>(Shapes{fcl::Cylinderd(SafeRadius(base, config), height),
                                            config.min_height_m + 0.5 * height,
                                            std::nullopt,
                                            {}});
  shapes_->footprint.computeLocalAABB();
  const world::BrickGrid& grid = space.surroundings();
  Eigen::AlignedBox3d band_W = grid.box_W();
  band_W.min().z() = config.min_height_m;
  band_W.max().z() = base.height;
  auto octree = std::make_shared<octomap::OcTree>(world::OccupiedOctree(grid, band_W));
  if (octree->size() > 0) {
    shapes_->map.emplace(std::shared_ptr<const octomap::OcTree>(std::move(octree)));
    shapes_->map->computeLocalAABB();
  }
  for (const world::SupportPlane& support_W : supports_W) {
    const geometry::PlacedShape solid = world::SolidBelow(support_W, config.support_margin_m);
    shapes_->solids.push_back({geometry::MakeCollisionShape(solid.shape, 0.0), solid.X_AS});
  }
}

CollisionChecker::~CollisionChecker() = default;
CollisionChecker::CollisionChecker(CollisionChecker&&) noexcept = default;
CollisionChecker& CollisionChecker::operator=(CollisionChecker&&) noexcept = default;

std::optional<Contact> CollisionChecker::Touches(const Pose2& X_WB) const {
  if (!std::isfinite(X_WB.x + X_WB.y + X_WB.yaw)) {
    Throw<InvalidArgument>("collision: the pose ({}, {}) m, {} rad is not finite", X_WB.x, X_WB.y,
                           X_WB.yaw);
  }
  Pose X_WF = ToPose(X_WB);
  X_WF.translation().z() = shapes_->middle;
  for (const Solid& solid : shapes_->solids) {
    const auto p_WQ = FirstContact(shapes_->footprint, X_WF, *solid.geometry, solid.X_WS);
    if (p_WQ) return Contact{true, *p_WQ};
  }
  if (!shapes_->map) return std::nullopt;
  const auto p_WQ = FirstContact(*shapes_->map, Pose::Identity(), shapes_->footprint, X_WF);
  if (p_WQ) return Contact{false, *p_WQ};
  return std::nullopt;
}

}  // namespace secondlook::planning
