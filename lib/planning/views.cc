#include "lib/planning/views.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "lib/common/error.h"
#include "lib/common/parallel.h"

namespace secondlook::planning {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// Adds the check to `look` and returns whether it passed.
bool Check(const char* name, bool passed, std::string detail, world::Look* look) {
  if (!passed) look->reason = fmt::format("{}: {}", name, detail);
  look->checks.push_back({name, passed, std::move(detail)});
  return passed;
}

bool CheckHead(const Eigen::Vector3d& p_WT, const CameraCarrier& carrier, world::Look* look) {
  const Pose X_WB = ToPose(look->X_WB);
  const std::optional<kinematics::HeadAngles> angles =
      kinematics::AimAt(carrier.head, X_WB.inverse() * p_WT);
  if (!angles) {
    return Check("pan-tilt limits", false, "the target lies on the pan axis or in the camera",
                 look);
  }
  look->head = {angles->pan, angles->tilt};
  look->X_WC = X_WB * kinematics::CameraInBase(carrier.head, *angles);
  const hal::PanTiltAngles& lower = carrier.pan_tilt.lower;
  const hal::PanTiltAngles& upper = carrier.pan_tilt.upper;
  return Check("pan-tilt limits", carrier.pan_tilt.Reaches(look->head),
               fmt::format("pan {:.1f} in {:.1f}..{:.1f} deg, tilt {:.1f} in {:.1f}..{:.1f} deg",
                           look->head.pan / kDegree, lower.pan / kDegree, upper.pan / kDegree,
                           look->head.tilt / kDegree, lower.tilt / kDegree, upper.tilt / kDegree),
               look);
}

bool CheckRange(const Eigen::Vector3d& p_WT, const hal::CameraInfo& camera, world::Look* look) {
  if (!camera.has_depth) return true;
  const double depth = (look->X_WC.inverse() * p_WT).z();
  return Check(
      "range", depth >= camera.min_depth && depth <= camera.max_depth,
      fmt::format("{:.2f} m in {:.2f}..{:.2f} m", depth, camera.min_depth, camera.max_depth), look);
}

bool CheckCollision(const CollisionChecker& collision, world::Look* look) {
  const std::optional<Contact> contact = collision.Touches(look->X_WB);
  if (!contact) return Check("collision", true, "free", look);
  return Check("collision", false,
               fmt::format("with {} at ({:.2f}, {:.2f}, {:.2f}) m",
                           contact->support ? "a support surface" : "the map", contact->p_WQ.x(),
                           contact->p_WQ.y(), contact->p_WQ.z()),
               look);
}

bool CheckPath(const Reach& reach, const CameraCarrier& carrier, world::Look* look) {
  PlannedPath path = reach.routes.To(look->X_WB);
  if (!path.found) return Check("path", false, path.reason, look);
  look->path_W = std::move(path.waypoints_W);
  look->metres = path.metres;
  const double turn = std::max(std::abs(look->head.pan - reach.head.pan),
                               std::abs(look->head.tilt - reach.head.tilt));
  look->seconds = std::max(path.seconds, turn / carrier.pan_tilt.speed);
  return Check("path", true, fmt::format("{:.2f} m, {:.1f} s", look->metres, look->seconds), look);
}

}  // namespace

void ViewsConfig::Validate() const {
  if (!(inner_radius_m > 0.0 && inner_radius_m <= outer_radius_m && outer_radius_m <= 10.0)) {
    Throw<ConfigError>(
        "inner_radius_m = {} and outer_radius_m = {} must be 0 < inner <= outer <= 10",
        inner_radius_m, outer_radius_m);
  }
  if (poses < 2 || poses > 1000 || poses % 2 != 0) {
    Throw<ConfigError>("poses = {} must be an even number in 2..1000", poses);
  }
}

std::vector<world::Look> CandidateViews(const Eigen::Vector3d& p_WT, int target,
                                        const CameraCarrier& carrier, const Reach& reach,
                                        const ViewsConfig& config) {
  config.Validate();
  if (!p_WT.allFinite()) {
    Throw<InvalidArgument>("views: the position p_WT = ({}, {}, {}) m of target {} is not finite",
                           p_WT.x(), p_WT.y(), p_WT.z(), target);
  }
  if (!(carrier.pan_tilt.speed > 0.0)) {
    Throw<InvalidArgument>(
        "views: pan-tilt head '{}' with a speed of {} rad/s; it must be positive",
        carrier.pan_tilt.name, carrier.pan_tilt.speed);
  }
  const int each = config.poses / 2;
  std::vector<world::Look> looks(config.poses);
  ParallelFor(config.poses, [&](int i) {
    const bool outer = i >= each;
    const double step = 2.0 * std::numbers::pi / each;
    const double angle = outer ? (i - each + 0.5) * step : i * step;
    const double radius = outer ? config.outer_radius_m : config.inner_radius_m;
    world::Look& look = looks[i];
    look.kind = "aspect_graph";
    look.target = target;
    look.X_WB = {p_WT.x() + radius * std::cos(angle), p_WT.y() + radius * std::sin(angle),
                 WrapAngle(angle + std::numbers::pi)};
    look.feasible = CheckHead(p_WT, carrier, &look) && CheckRange(p_WT, carrier.camera, &look) &&
                    CheckCollision(reach.collision, &look) && CheckPath(reach, carrier, &look);
  });
  return looks;
}

}  // namespace secondlook::planning
