#include "apps/arm_looks.h"

#include <algorithm>
#include <utility>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/kinematics/box_of_moved.h"
#include "lib/planning/motion/stop_and_go.h"

namespace secondlook::apps {
namespace {

constexpr int kSegments = 12;         // of what is round
constexpr double kTolerance = 0.005;  // [m]

/// @throws ConfigError when a point of what the arm moves lies out of the base's cylinder.
void RequireFolded(const HandDevices& devices, const Eigen::VectorXd& q) {
  const kinematics::Chain& arm = devices.hand.arm;
  const std::vector<kinematics::Link>& links = arm.model().links;
  const std::vector<Pose> X_BL = arm.LinkPoses(q);
  double radius = 0.0;
  double height = 0.0;
  for (int l = 0; l < static_cast<int>(links.size()); ++l) {
    if (!arm.Moves(l)) continue;
    for (const geometry::PlacedShape& part : links[l].body) {
      const geometry::Mesh mesh =
          geometry::MakeMesh(part.shape, kSegments, Eigen::Vector3f::Zero());
      for (const Eigen::Vector3f& vertex : mesh.vertices) {
        const Eigen::Vector3d p_B = X_BL[l] * part.X_AS * vertex.cast<double>();
        radius = std::max(radius, p_B.head<2>().norm());
        height = std::max(height, p_B.z());
      }
    }
  }
  if (radius <= devices.base.radius + kTolerance && height <= devices.base.height + kTolerance) {
    return;
  }
  Throw<ConfigError>(
      "arm '{}': where it stands at the beginning it reaches {:.2f} m from the base's axis and "
      "{:.2f} m high, but base '{}' drives as a cylinder of {:.2f} m radius and {:.2f} m height; "
      "fold the arm before the mission, or give the base its real size",
      devices.arm.name, radius, height, devices.base.name, devices.base.radius,
      devices.base.height);
}

}  // namespace

void ArmLooksConfig::Validate() const {
  views.Validate();
  obstacles.Validate();
  collision.Validate();
  if (views.motion.step_m > 2.0 * collision.clearance_m) {
    Throw<ConfigError>(
        "views.motion.step_m = {} with collision.clearance_m = {}: between two tests the arm could "
        "pass through something; a step must be at most twice the clearance",
        views.motion.step_m, collision.clearance_m);
  }
}

ArmLooks::ArmLooks(const ArmLooksConfig& config, HandDevices devices, const Eigen::VectorXd& q,
                   std::uint64_t seed)
    : config_(config), devices_(std::move(devices)), way_(q), seed_(ForkSeed(seed, "arm")) {
  config_.Validate();
  RequireFolded(devices_, q);
}

void ArmLooks::KeepWithin(const Eigen::AlignedBox3d& box_B) {
  const Eigen::AlignedBox3d arm_B = kinematics::BoxOfMoved(devices_.hand.arm, way_.home());
  const Eigen::Vector3d clearance = Eigen::Vector3d::Constant(config_.collision.clearance_m);
  const Eigen::AlignedBox3d grown_B(arm_B.min() - clearance, arm_B.max() + clearance);
  if (!box_B.contains(grown_B)) {
    Throw<ConfigError>(
        "arm '{}': where it stands at the beginning it reaches from ({:.2f}, {:.2f}, {:.2f}) to "
        "({:.2f}, {:.2f}, {:.2f}) m in B, which with collision.clearance_m = {} is not within "
        "safety.limits.arm_workspace; fold the arm before the mission, or give it more room",
        devices_.arm.name, arm_B.min().x(), arm_B.min().y(), arm_B.min().z(), arm_B.max().x(),
        arm_B.max().y(), arm_B.max().z(), config_.collision.clearance_m);
  }
  workspace_B_ = box_B;
}

hal::JointTrajectory ArmLooks::Folding(const Eigen::VectorXd& q) const {
  return way_.Back(q, planning::Gently(devices_.arm.joints, config_.views.motion.speed_share));
}

planning::ArmCollision ArmLooks::CollisionAt(
    const Stance& stance, const world::VoxelSpace& space,
    const std::vector<world::SupportPlane>& supports_W) const {
  const kinematics::Chain& chain = devices_.hand.arm;
  const Pose X_WB = ToPose(stance.X_WB);
  std::vector<geometry::PlacedShape> own_W = chain.Body(stance.q);
  own_W.push_back({geometry::Cylinder{devices_.base.radius, devices_.base.height},
                   Pose(Eigen::Translation3d(0.0, 0.0, 0.5 * devices_.base.height))});
  for (geometry::PlacedShape& part : own_W) part.X_AS = X_WB * part.X_AS;
  const Eigen::Vector3d p_WS = X_WB * chain.LinkPoses(stance.q)[chain.link_of(0)].translation();
  std::vector<planning::Obstacle> obstacles_W = planning::ObstaclesAround(
      p_WS, planning::ReachOf(chain), space, supports_W, own_W, config_.obstacles);
  if (workspace_B_) {
    for (planning::Obstacle& wall : planning::WallsAround(*workspace_B_, X_WB)) {
      obstacles_W.push_back(std::move(wall));
    }
  }
  return {chain, X_WB, obstacles_W, config_.collision};
}

std::vector<world::Look> ArmLooks::Views(const Eigen::Vector3d& p_WT, int target,
                                         const Stance& stance,
                                         const planning::ArmCollision& collision) {
  return planning::ArmViews(
      p_WT, target,
      {devices_.arm, devices_.hand, devices_.camera, stance.X_WB, stance.head, stance.q}, collision,
      ForkSeed(seed_, fmt::format("{}", planned_++)), config_.views);
}

}  // namespace secondlook::apps
