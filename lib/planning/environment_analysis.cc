#include "lib/planning/environment_analysis.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace secondlook::planning {
namespace {

/// Where the ray from `from_W` enters the box; empty when it misses it. 0 from inside.
std::optional<double> Entry(const Eigen::AlignedBox3d& box_W, const Eigen::Vector3d& from_W,
                            const Eigen::Vector3d& direction_W) {
  double enter = 0.0;
  double leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box_W.min()[axis] - from_W[axis];
    const double high = box_W.max()[axis] - from_W[axis];
    if (direction_W[axis] == 0.0) {
      if (low > 0.0 || high < 0.0) return std::nullopt;
      continue;
    }
    const double a = low / direction_W[axis];
    const double b = high / direction_W[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave) return std::nullopt;
  return enter;
}

/// The pixels, first and last along each axis, outside of which no ray meets the box.
struct PixelRange {
  Eigen::Vector2i first;
  Eigen::Vector2i last;
};

PixelRange Projection(const Eigen::AlignedBox3d& box_W, const geometry::CameraModel& camera,
                      const Pose& X_WC) {
  const Eigen::Vector2i end(camera.width - 1, camera.height - 1);
  Eigen::AlignedBox2d pixels;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p_CQ =
        X_WC.inverse() * box_W.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    if (p_CQ.z() < 1e-3) return {Eigen::Vector2i::Zero(), end};  // beside or behind the lens
    pixels.extend(Eigen::Vector2d(camera.fx * p_CQ.x() / p_CQ.z() + camera.cx,
                                  camera.fy * p_CQ.y() / p_CQ.z() + camera.cy));
  }
  const auto clamp = [&](const Eigen::Array2d& pixel) -> Eigen::Vector2i {
    return pixel.max(-1.0).min(end.cast<double>().array() + 1.0).cast<int>();
  };
  return {clamp(pixels.min().array().ceil()).cwiseMax(0),
          clamp(pixels.max().array().floor()).cwiseMin(end)};
}

}  // namespace

BoxRays CastToBox(const world::VoxelSpace& space, const geometry::CameraModel& camera,
                  const Pose& X_WC, const Eigen::AlignedBox3d& box_W,
                  const AspectGraphConfig& config) {
  // Not grown downwards: what lies below the target holds it and belongs to it nowhere.
  Eigen::AlignedBox3d around_W = box_W;
  around_W.min().head<2>().array() -= config.box_margin_m;
  around_W.max().array() += config.box_margin_m;

  const Eigen::Vector3d p_WC = X_WC.translation();
  const PixelRange range = Projection(box_W, camera, X_WC);
  const Eigen::Vector2i size = (range.last - range.first + Eigen::Vector2i::Ones()).cwiseMax(0);
  world::RayFan fan{camera, X_WC, range.first, size, {}};
  BoxRays cast;
  std::vector<BoxRay>& rays = cast.rays;
  std::vector<std::size_t> pixels;  // of the fan, one a ray
  for (int v = range.first.y(); v <= range.last.y(); ++v) {
    for (int u = range.first.x(); u <= range.last.x(); ++u) {
      const Eigen::Vector3d direction_W = X_WC.linear() * camera.Ray(u, v);
      fan.depth.push_back(0.0);
      if (!Entry(box_W, p_WC, direction_W)) continue;
      fan.depth.back() = Entry(around_W, p_WC, direction_W).value_or(0.0);
      pixels.push_back(fan.depth.size() - 1);
      rays.push_back({direction_W, 1.0});
    }
  }
  const std::vector<world::Passage> passages = space.Cast(fan);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const world::Passage& passage = passages[pixels[i]];
    const bool through_unknown = !passage.blocked && passage.unknown > config.unknown_m;
    rays[i].stopped = passage.blocked;
    rays[i].through_unknown = through_unknown;
    rays[i].chance = passage.blocked ? 0.0 : through_unknown ? config.unknown_survival : 1.0;
    cast.blocked += passage.blocked ? 1.0 : 0.0;
    cast.through_unknown += through_unknown ? 1.0 : 0.0;
    cast.surviving += rays[i].chance;
  }
  if (rays.empty()) return cast;
  const auto count = static_cast<double>(rays.size());
  cast.blocked /= count;
  cast.through_unknown /= count;
  cast.surviving /= count;
  return cast;
}

}  // namespace secondlook::planning
