#include "lib/planning/arm_views.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/planning/look_check.h"

namespace secondlook::planning {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

bool CheckDepth(double distance, const hal::CameraInfo& camera, world::Look* look) {
  if (!camera.has_depth) return true;
  return AddCheck(
      "range", distance >= camera.min_depth && distance <= camera.max_depth,
      fmt::format("{:.2f} m in {:.2f}..{:.2f} m", distance, camera.min_depth, camera.max_depth),
      look);
}

/// Where the cameras of all candidates are.
std::vector<Eigen::Vector3d> CamerasAround(const Eigen::Vector3d& p_WT,
                                           const ArmViewsConfig& config) {
  std::vector<Eigen::Vector3d> cameras_W;
  for (const double distance : {config.inner_distance_m, config.outer_distance_m}) {
    for (int ring = 0; ring < config.elevations; ++ring) {
      const double share = config.elevations == 1 ? 0.5 : ring / (config.elevations - 1.0);
      const double elevation =
          kRadians * (config.lowest_elevation_deg +
                      share * (config.highest_elevation_deg - config.lowest_elevation_deg));
      for (int i = 0; i < config.azimuths; ++i) {
        const double azimuth = 2.0 * std::numbers::pi / config.azimuths * (i + 0.5 * (ring % 2));
        cameras_W.push_back(p_WT +
                            distance * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                                       std::cos(elevation) * std::sin(azimuth),
                                                       std::sin(elevation)));
      }
    }
  }
  return cameras_W;
}

/// False where no joint angles could bring the camera so far, which is soon told.
bool CheckReach(const ArmCarrier& carrier, world::Look* look) {
  const kinematics::Chain& arm = carrier.hand.arm;
  const Pose X_WS = ToPose(carrier.X_WB) * arm.LinkPoses(carrier.q)[arm.link_of(0)];
  const double distance = (look->X_WC.translation() - X_WS.translation()).norm();
  const double reach = ReachOf(arm) + carrier.hand.X_EC.translation().norm();
  return AddCheck("reach", distance <= reach,
                  fmt::format("{:.2f} m from the first joint, at most {:.2f} m", distance, reach),
                  look);
}

/// The joint angles that bring the camera there, any roll will do.
std::vector<Eigen::VectorXd> CheckInverseKinematics(const ArmCarrier& carrier,
                                                    const ArmViewsConfig& config,
                                                    world::Look* look) {
  const Pose X_BC = ToPose(carrier.X_WB).inverse() * look->X_WC;
  kinematics::JointSolutions solutions = kinematics::SolveInverseKinematics(
      carrier.hand.arm, {X_BC, carrier.hand.X_EC, true}, carrier.q, config.inverse_kinematics);
  AddCheck("inverse kinematics", !solutions.q.empty(),
           solutions.q.empty() ? solutions.reason : fmt::format("{} ways", solutions.q.size()),
           look);
  return std::move(solutions.q);
}

/// Those of `postures` that touch nothing.
std::vector<Eigen::VectorXd> CheckCollision(const std::vector<Eigen::VectorXd>& postures,
                                            const ArmCollision& collision, world::Look* look) {
  std::vector<Eigen::VectorXd> free;
  std::string first;
  for (const Eigen::VectorXd& q : postures) {
    const std::optional<std::string> touch = collision.Touches(q);
    if (!touch) free.push_back(q);
    if (touch && first.empty()) first = *touch;
  }
  AddCheck("collision", !free.empty(), free.empty() ? first : "free", look);
  return free;
}

/// The first of `postures` that has a way there.
bool CheckPath(const std::vector<Eigen::VectorXd>& postures, const ArmCarrier& carrier,
               const ArmCollision& collision, std::uint64_t seed, const MotionConfig& config,
               world::Look* look) {
  std::string reason;
  for (const Eigen::VectorXd& q : postures) {
    PlannedMotion motion = PlanMotion(collision, carrier.arm.joints, carrier.q, q, seed, config);
    if (motion.outcome != MotionOutcome::kFound) {
      if (reason.empty()) reason = std::move(motion.reason);
      continue;
    }
    look->arm_motion = std::move(motion.trajectory);
    look->seconds = look->arm_motion.seconds();
    // Any roll would do; this is the one that it has there.
    look->X_WC = ToPose(carrier.X_WB) * kinematics::CameraInBase(carrier.hand, q);
    return AddCheck("path", true, fmt::format("{:.1f} s", look->seconds), look);
  }
  return AddCheck("path", false, reason, look);
}

bool CheckAll(const ArmCarrier& carrier, const ArmCollision& collision, double distance,
              std::uint64_t seed, const ArmViewsConfig& config, world::Look* look) {
  if (!CheckDepth(distance, carrier.camera, look) || !CheckReach(carrier, look)) return false;
  const std::vector<Eigen::VectorXd> reaching = CheckInverseKinematics(carrier, config, look);
  if (reaching.empty()) return false;
  const std::vector<Eigen::VectorXd> free = CheckCollision(reaching, collision, look);
  if (free.empty()) return false;
  return CheckPath(free, carrier, collision, seed, config.motion, look);
}

}  // namespace

void ArmViewsConfig::Validate() const {
  CheckRange(inner_distance_m, 0.05, 3.0, "inner_distance_m");
  CheckRange(outer_distance_m, inner_distance_m, 3.0, "outer_distance_m");
  CheckRange(lowest_elevation_deg, 0.0, 89.0, "lowest_elevation_deg");
  CheckRange(highest_elevation_deg, lowest_elevation_deg, 89.0, "highest_elevation_deg");
  CheckRange(elevations, 1, 100, "elevations");
  CheckRange(azimuths, 1, 100, "azimuths");
  inverse_kinematics.Validate();
  motion.Validate();
}

std::vector<world::Look> ArmViews(const Eigen::Vector3d& p_WT, int target,
                                  const ArmCarrier& carrier, const ArmCollision& collision,
                                  std::uint64_t seed, const ArmViewsConfig& config) {
  config.Validate();
  if (!p_WT.allFinite()) {
    Throw<InvalidArgument>(
        "arm views: the position p_WT = ({}, {}, {}) m of target {} is not finite", p_WT.x(),
        p_WT.y(), p_WT.z(), target);
  }
  std::vector<world::Look> looks;
  for (const Eigen::Vector3d& p_WC : CamerasAround(p_WT, config)) {
    world::Look look;
    look.kind = "arm";
    look.target = target;
    look.way = world::LookWay::kArm;
    look.X_WB = carrier.X_WB;
    look.head = carrier.head;
    look.X_WC = LookAt(p_WC, p_WT);
    const std::uint64_t own = ForkSeed(seed, fmt::format("arm view {}", looks.size()));
    look.feasible = CheckAll(carrier, collision, (p_WC - p_WT).norm(), own, config, &look);
    looks.push_back(std::move(look));
  }
  return looks;
}

}  // namespace secondlook::planning
