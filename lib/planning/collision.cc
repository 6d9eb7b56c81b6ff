#include "lib/planning/collision.h"

#include <algorithm>
#include <cmath>

#include <fcl/fcl.h>
#include <octomap/OcTree.h>

#include "lib/common/error.h"
#include "lib/world/octomap_exchange.h"

namespace secondlook::planning {
namespace {

/// What a support surface stands on, from the floor to its top.
struct Solid {
  fcl::Boxd box;
  Pose X_WS;  ///< Of the box's centre.
};

Solid SolidBelow(const world::SupportPlane& support_W, double margin) {
  const auto& corners_W = support_W.corners_A;
  const Eigen::Vector3d middle_W =
      0.25 * (corners_W[0] + corners_W[1] + corners_W[2] + corners_W[3]);
  const Eigen::Vector3d along = corners_W[1] - corners_W[0];
  const Eigen::Vector3d across = corners_W[2] - corners_W[1];
  const double top = std::max(middle_W.z(), 1e-3);
  Solid solid{
      fcl::Boxd(along.head<2>().norm() + 2.0 * margin, across.head<2>().norm() + 2.0 * margin, top),
      ToPose({middle_W.x(), middle_W.y(), std::atan2(along.y(), along.x())})};
  solid.X_WS.translation().z() = 0.5 * top;
  return solid;
}

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
    shapes_->solids.push_back(SolidBelow(support_W, config.support_margin_m));
    shapes_->solids.back().box.computeLocalAABB();
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
    const auto p_WQ = FirstContact(shapes_->footprint, X_WF, solid.box, solid.X_WS);
    if (p_WQ) return Contact{true, *p_WQ};
  }
  if (!shapes_->map) return std::nullopt;
  const auto p_WQ = FirstContact(*shapes_->map, Pose::Identity(), shapes_->footprint, X_WF);
  if (p_WQ) return Contact{false, *p_WQ};
  return std::nullopt;
}

}  // namespace secondlook::planning
