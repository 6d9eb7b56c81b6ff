#include "lib/planning/views.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/common/parallel.h"
#include "lib/geometry/point_image.h"
#include "lib/planning/look_check.h"

namespace secondlook::planning {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

bool CheckHead(const Eigen::Vector3d& p_WT, const CameraCarrier& carrier, world::Look* look) {
  const Pose X_WB = ToPose(look->X_WB);
  const std::optional<kinematics::HeadAngles> angles =
      kinematics::AimAt(carrier.head, X_WB.inverse() * p_WT);
  if (!angles) {
    return AddCheck("pan-tilt limits", false, "the target lies on the pan axis or in the camera",
                    look);
  }
  look->head = {angles->pan, angles->tilt};
  look->X_WC = X_WB * kinematics::CameraInBase(carrier.head, *angles);
  const hal::PanTiltAngles& lower = carrier.pan_tilt.lower;
  const hal::PanTiltAngles& upper = carrier.pan_tilt.upper;
  return AddCheck(
      "pan-tilt limits", carrier.pan_tilt.Reaches(look->head),
      fmt::format("pan {:.1f} in {:.1f}..{:.1f} deg, tilt {:.1f} in {:.1f}..{:.1f} deg",
                  look->head.pan / kDegree, lower.pan / kDegree, upper.pan / kDegree,
                  look->head.tilt / kDegree, lower.tilt / kDegree, upper.tilt / kDegree),
      look);
}

bool CheckRange(const Eigen::Vector3d& p_WT, const hal::CameraInfo& camera, world::Look* look) {
  if (!camera.has_depth) return true;
  const double depth = (look->X_WC.inverse() * p_WT).z();
  return AddCheck(
      "range", depth >= camera.min_depth && depth <= camera.max_depth,
      fmt::format("{:.2f} m in {:.2f}..{:.2f} m", depth, camera.min_depth, camera.max_depth), look);
}

bool CheckCollision(const CollisionChecker& collision, world::Look* look) {
  const std::optional<Contact> contact = collision.Touches(look->X_WB);
  if (!contact) return AddCheck("collision", true, "free", look);
  return AddCheck("collision", false,
                  fmt::format("with {} at ({:.2f}, {:.2f}, {:.2f}) m",
                              contact->support ? "a support surface" : "the map", contact->p_WQ.x(),
                              contact->p_WQ.y(), contact->p_WQ.z()),
                  look);
}

bool CheckPath(const Reach& reach, const CameraCarrier& carrier, world::Look* look) {
  PlannedPath path = reach.routes.To(look->X_WB);
  if (!path.found) return AddCheck("path", false, path.reason, look);
  look->path_W = std::move(path.waypoints_W);
  look->metres = path.metres;
  const double turn = std::max(std::abs(look->head.pan - reach.head.pan),
                               std::abs(look->head.tilt - reach.head.tilt));
  look->seconds = std::max(path.seconds, turn / carrier.pan_tilt.speed);
  return AddCheck("path", true, fmt::format("{:.2f} m, {:.1f} s", look->metres, look->seconds),
                  look);
}

/// The base `radius` [m] from the target in direction `angle` [rad], facing it, with all checks.
world::Look ViewFrom(double angle, double radius, const Eigen::Vector3d& p_WT, int target,
                     const CameraCarrier& carrier, const Reach& reach) {
  world::Look look;
  look.kind = "aspect_graph";
  look.target = target;
  look.X_WB = {p_WT.x() + radius * std::cos(angle), p_WT.y() + radius * std::sin(angle),
               WrapAngle(angle + std::numbers::pi)};
  look.feasible = CheckHead(p_WT, carrier, &look) && CheckRange(p_WT, carrier.camera, &look) &&
                  CheckCollision(reach.collision, &look) && CheckPath(reach, carrier, &look);
  return look;
}

void CheckInput(const Eigen::Vector3d& p_WT, int target, const CameraCarrier& carrier) {
  if (!p_WT.allFinite()) {
    Throw<InvalidArgument>("views: the position p_WT = ({}, {}, {}) m of target {} is not finite",
                           p_WT.x(), p_WT.y(), p_WT.z(), target);
  }
  if (!(carrier.pan_tilt.speed > 0.0)) {
    Throw<InvalidArgument>(
        "views: pan-tilt head '{}' with a speed of {} rad/s; it must be positive",
        carrier.pan_tilt.name, carrier.pan_tilt.speed);
  }
}

/// The distance [m] at which the depth's sigma reaches `sigma` (geometry::DepthSigma).
double DepthOfSigma(double sigma) {
  double low = 0.4;
  double high = 20.0;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (geometry::DepthSigma(middle) > sigma ? high : low) = middle;
  }
  return low;
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
  secondlook::CheckRange(placed, 0, 1000, "placed");
  secondlook::CheckRange(max_depth_sigma_m, 0.0012, 1.0, "max_depth_sigma_m");
  secondlook::CheckRange(min_target_px, 0.0, 1e4, "min_target_px");
}

std::vector<world::Look> CandidateViews(const Eigen::Vector3d& p_WT, int target,
                                        const CameraCarrier& carrier, const Reach& reach,
                                        const ViewsConfig& config) {
  config.Validate();
  CheckInput(p_WT, target, carrier);
  const int each = config.poses / 2;
  std::vector<world::Look> looks(config.poses);
  ParallelFor(config.poses, [&](int i) {
    const bool outer = i >= each;
    const double step = 2.0 * std::numbers::pi / each;
    const double angle = outer ? (i - each + 0.5) * step : i * step;
    const double radius = outer ? config.outer_radius_m : config.inner_radius_m;
    looks[i] = ViewFrom(angle, radius, p_WT, target, carrier, reach);
  });
  return looks;
}

DistanceRange UsefulDistances(const Eigen::AlignedBox3d& box_W, const CameraCarrier& carrier,
                              const ViewsConfig& config) {
  const geometry::CameraModel& camera = carrier.camera.model;
  const double focal = std::min(camera.fx, camera.fy);
  const double size = box_W.diagonal().norm();
  double near = focal * size / std::min(camera.width, camera.height);
  double far = focal * size / std::max(config.min_target_px, 1.0);
  if (carrier.camera.has_depth) {
    near = std::max(near, carrier.camera.min_depth + 0.5 * size);
    far = std::min({far, carrier.camera.max_depth, DepthOfSigma(config.max_depth_sigma_m)});
  }
  // Along the floor, as the camera is higher or lower than the target.
  const double drop = (carrier.head.X_BH0.translation().z() - box_W.center().z());
  const auto along_floor = [&](double distance) {
    return std::sqrt(std::max(0.0, distance * distance - drop * drop));
  };
  return {along_floor(near), along_floor(far)};
}

std::vector<world::Look> PlacedViews(const Eigen::AlignedBox3d& box_W, int target,
                                     const CameraCarrier& carrier, const Reach& reach,
                                     const ViewsConfig& config) {
  config.Validate();
  if (box_W.isEmpty()) Throw<InvalidArgument>("views: the box of target {} is empty", target);
  const Eigen::Vector3d p_WT = box_W.center();
  CheckInput(p_WT, target, carrier);
  const DistanceRange range = UsefulDistances(box_W, carrier, config);
  if (!(range.near < range.far)) return {};
  constexpr int kTries = 3;                            // for each that is wanted
  constexpr double kPlastic = 1.32471795724474602596;  // the R2 sequence's
  std::vector<world::Look> tried(static_cast<std::size_t>(kTries) * config.placed);
  ParallelFor(static_cast<int>(tried.size()), [&](int i) {
    const double turn = std::fmod(0.5 + (i + 1) / kPlastic, 1.0);
    const double share = std::fmod(0.5 + (i + 1) / (kPlastic * kPlastic), 1.0);
    const double radius = range.near + share * (range.far - range.near);
    tried[i] = ViewFrom(2.0 * std::numbers::pi * turn, radius, p_WT, target, carrier, reach);
  });
  std::vector<world::Look> looks;
  for (world::Look& look : tried) {
    if (!look.feasible || static_cast<int>(looks.size()) == config.placed) continue;
    looks.push_back(std::move(look));
  }
  return looks;
}

}  // namespace secondlook::planning
