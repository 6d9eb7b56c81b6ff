#include "lib/planning/motion/arm_collision.h"

#include <algorithm>
#include <utility>

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/geometry/collision_shape.h"

namespace secondlook::planning {
namespace {

using kinematics::Chain;
using kinematics::Link;

/// For each link the one that stands for all that are rigidly fixed to it.
std::vector<int> RigidGroups(const std::vector<Link>& links) {
  std::vector<int> group(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const bool own = links[i].parent < 0 || links[i].joint.turns;
    group[i] = own ? static_cast<int>(i) : group[links[i].parent];
  }
  return group;
}

/// The group that the joint of a group hangs on; -1 for the root.
int ParentGroup(int group, const std::vector<Link>& links, const std::vector<int>& groups) {
  return links[group].parent < 0 ? -1 : groups[links[group].parent];
}

/// Obstacles carry their kind as user data, links of the robot none.
struct FirstHit {
  const ObstacleKind* kind{};
  Eigen::Vector3d point{0.0, 0.0, 0.0};
};

bool NoteFirst(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* data) {
  auto* hit = static_cast<FirstHit*>(data);
  const fcl::CollisionRequestd request(1, true);
  fcl::CollisionResultd result;
  if (fcl::collide(a, b, request, result) == 0) return false;
  const void* kind = a->getUserData() != nullptr ? a->getUserData() : b->getUserData();
  *hit = {static_cast<const ObstacleKind*>(kind), result.getContact(0).pos};
  return true;
}

}  // namespace

void ArmCollisionConfig::Validate() const {
  CheckRange(clearance_m, 0.0, 1.0, "clearance_m");
  CheckRange(self_clearance_m, 0.0, 0.1, "self_clearance_m");
}

std::vector<double> MotionRadii(const Chain& chain) {
  const std::vector<Link>& links = chain.model().links;
  std::vector<double> radii;
  for (int i = 0; i < chain.size(); ++i) {
    std::vector<double> way(links.size(),
                            -1.0);  // from the joint's axis; negative: not moved by it
    way[chain.link_of(i)] = 0.0;
    double radius = 0.0;
    for (std::size_t l = chain.link_of(i); l < links.size(); ++l) {
      if (way[l] < 0.0 && way[links[l].parent] < 0.0) continue;
      if (way[l] < 0.0) way[l] = way[links[l].parent] + links[l].joint.X_PL.translation().norm();
      radius = std::max(radius, way[l]);
      for (const geometry::PlacedShape& part : links[l].body) {
        radius = std::max(
            radius, way[l] + part.X_AS.translation().norm() + geometry::BoundingRadius(part.shape));
      }
    }
    radii.push_back(radius);
  }
  return radii;
}

double ReachOf(const Chain& chain) { return MotionRadii(chain).front(); }

struct ArmCollision::Shapes {
  struct Part {
    int link;
    Pose X_LS;
    fcl::CollisionObjectd near_obstacles;  // grown by the clearance
    fcl::CollisionObjectd near_links;      // grown by half of the clearance between links
  };
  Chain chain;
  Pose X_WB;
  ArmCollisionConfig config;
  std::vector<Part> parts;                      // of all links
  std::vector<std::pair<int, int>> self_pairs;  // of parts that must not touch each other
  std::vector<ObstacleKind> kinds;              // of the obstacles, which point to them
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> obstacles;
  fcl::DynamicAABBTreeCollisionManagerd tree;

  void Place(const Eigen::VectorXd& q) {
    const std::vector<Pose> X_BL = chain.LinkPoses(q);
    for (Part& part : parts) {
      const Pose X_WS = X_WB * X_BL[part.link] * part.X_LS;
      for (fcl::CollisionObjectd* object : {&part.near_obstacles, &part.near_links}) {
        object->setTransform(X_WS);
        object->computeAABB();
      }
    }
  }

  /// The first part of a moved link that meets an obstacle.
  std::optional<std::pair<int, FirstHit>> HitObstacle() {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (!chain.Moves(parts[i].link)) continue;
      FirstHit hit;
      tree.collide(&parts[i].near_obstacles, &hit, NoteFirst);
      if (hit.kind != nullptr) return std::pair{static_cast<int>(i), hit};
    }
    return std::nullopt;
  }

  /// The first pair of parts that meet each other.
  std::optional<std::pair<int, int>> HitItself() const {
    const fcl::CollisionRequestd request;
    for (const auto& [a, b] : self_pairs) {
      const fcl::CollisionObjectd& first = parts[a].near_links;
      const fcl::CollisionObjectd& second = parts[b].near_links;
      if (!first.getAABB().overlap(second.getAABB())) continue;
      fcl::CollisionResultd result;
      if (fcl::collide(&first, &second, request, result) != 0) return std::pair{a, b};
    }
    return std::nullopt;
  }
};

ArmCollision::ArmCollision(Chain chain, const Pose& X_WB, const std::vector<Obstacle>& obstacles_W,
                           const ArmCollisionConfig& config)
    : shapes_(new Shapes{std::move(chain), X_WB, config, {}, {}, {}, {}, {}}) {
  config.Validate();
  const std::vector<Link>& links = shapes_->chain.model().links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    for (const geometry::PlacedShape& body : links[i].body) {
      shapes_->parts.push_back(
          {static_cast<int>(i), body.X_AS,
           fcl::CollisionObjectd(geometry::MakeCollisionShape(body.shape, config.clearance_m)),
           fcl::CollisionObjectd(
               geometry::MakeCollisionShape(body.shape, 0.5 * config.self_clearance_m))});
    }
  }
  const std::vector<int> groups = RigidGroups(links);
  const int count = static_cast<int>(shapes_->parts.size());
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      const int first = groups[shapes_->parts[a].link];
      const int second = groups[shapes_->parts[b].link];
      if (first == second || ParentGroup(first, links, groups) == second ||
          ParentGroup(second, links, groups) == first) {
        continue;
      }
      shapes_->self_pairs.emplace_back(a, b);
    }
  }
  for (const Obstacle& obstacle : obstacles_W) shapes_->kinds.push_back(obstacle.kind);
  for (std::size_t i = 0; i < obstacles_W.size(); ++i) {
    const Obstacle& obstacle = obstacles_W[i];
    shapes_->obstacles.push_back(std::make_unique<fcl::CollisionObjectd>(
        geometry::MakeCollisionShape(obstacle.solid.shape, 0.0), obstacle.solid.X_AS));
    shapes_->obstacles.back()->computeAABB();
    shapes_->obstacles.back()->setUserData(&shapes_->kinds[i]);
  }
  std::vector<fcl::CollisionObjectd*> objects;
  for (const auto& object : shapes_->obstacles) objects.push_back(object.get());
  shapes_->tree.registerObjects(objects);
  shapes_->tree.setup();
}

ArmCollision::~ArmCollision() = default;
ArmCollision::ArmCollision(ArmCollision&&) noexcept = default;
ArmCollision& ArmCollision::operator=(ArmCollision&&) noexcept = default;

const Chain& ArmCollision::chain() const { return shapes_->chain; }

const ArmCollisionConfig& ArmCollision::config() const { return shapes_->config; }

bool ArmCollision::Free(const Eigen::VectorXd& q) const {
  shapes_->Place(q);
  return !shapes_->HitItself() && !shapes_->HitObstacle();
}

std::optional<std::string> ArmCollision::Touches(const Eigen::VectorXd& q) const {
  shapes_->Place(q);
  const std::vector<Link>& links = shapes_->chain.model().links;
  const auto name = [&](int part) { return links[shapes_->parts[part].link].name; };
  if (const auto pair = shapes_->HitItself()) {
    return fmt::format("link '{}' with link '{}'", name(pair->first), name(pair->second));
  }
  const auto hit = shapes_->HitObstacle();
  if (!hit) return std::nullopt;
  const Eigen::Vector3d& p_W = hit->second.point;
  return fmt::format("link '{}' with {} at ({:.2f}, {:.2f}, {:.2f}) m in W", name(hit->first),
                     ToString(*hit->second.kind), p_W.x(), p_W.y(), p_W.z());
}

}  // namespace secondlook::planning
