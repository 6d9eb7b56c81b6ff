#include "lib/planning/scan_gain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "lib/common/check_range.h"
#include "lib/geometry/kd_tree.h"
#include "lib/geometry/mesh_border.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using world::Brick;

constexpr double kNever = 1e300;
/// Voxels; a ray ends so much before it leaves the grid.
constexpr double kRounding = 1e-6;
/// Voxels farther from every trend than this many decays are not thought to hold surface.
constexpr double kDecays = 3.0;

double Entropy(double p) {
  return p <= 0.0 || p >= 1.0 ? 0.0 : -p * std::log2(p) - (1.0 - p) * std::log2(1.0 - p);
}

}  // namespace

void ScanGainConfig::Validate() const {
  CheckRange(lambda, 0.0, 1.0, "lambda");
  CheckRange(quality_scans, 0.1, 1000.0, "quality_scans");
  CheckRange(max_range_m, 0.01, 10.0, "max_range_m");
  CheckRange(stride, 1, 32, "stride");
  CheckRange(trend_decay_m, 1e-3, 1.0, "trend_decay_m");
  CheckRange(max_incidence_deg, 1.0, 89.0, "max_incidence_deg");
  CheckRange(unknown_m, 0.0, 10.0, "unknown_m");
  CheckRange(unknown_survival, 0.0, 1.0, "unknown_survival");
}

ScanGainField::ScanGainField(const world::BrickGrid& grid, const world::PartialMesh& surface,
                             const std::vector<SurfaceTrend>& trends,
                             const world::SupportPlane& plane_W, const ScanGainConfig& config)
    : config_(config),
      voxel_(grid.voxel()),
      low_W_(grid.first_key().cast<double>() * grid.voxel()),
      size_(grid.brick_count() * Brick::kEdge) {
  config.Validate();
  const auto index_of = [&](const Vector3i& at) {
    return static_cast<std::size_t>(at.x()) +
           static_cast<std::size_t>(size_.x()) *
               (at.y() + static_cast<std::size_t>(size_.y()) * at.z());
  };
  cells_.assign(static_cast<std::size_t>(size_.cast<std::int64_t>().prod()), kBit);
  notes_.assign(cells_.size(), -1);
  for (int b = 0; b < grid.directory_size(); ++b) {
    const Brick* brick = grid.Find(b);
    if (brick == nullptr) continue;
    const Vector3i corner = (grid.BrickAt(b) - grid.first_brick()) * Brick::kEdge;
    for (int i = 0; i < Brick::kVoxels; ++i) {
      const world::Occupancy state = brick->At(i);
      if (state == world::Occupancy::kUnknown) continue;
      const bool known = (brick->known[i >> 6] >> (i & 63) & 1) != 0;
      const double entropy = known ? Entropy(world::Probability(brick->log_odds[i])) : 0.0;
      Cell& cell = cells_[index_of(corner + Vector3i(i & 7, i >> 3 & 7, i >> 6))];
      cell = static_cast<Cell>(std::lround(kBit * entropy));
      if (state == world::Occupancy::kOccupied) cell |= kEnd;
    }
  }
  const auto note = [&](std::size_t index, std::int32_t value) {
    cells_[index] |= kNoted;
    notes_[index] = value;
  };

  // Quality: the mean over the vertices in a voxel.
  std::vector<char> at_border(surface.mesh.vertices.size(), 0);
  for (const std::vector<int>& loop : geometry::BorderLoops(surface.mesh)) {
    for (const int vertex : loop) at_border[vertex] = 1;
  }
  std::vector<float> counts;
  for (std::size_t i = 0; i < surface.mesh.vertices.size(); ++i) {
    const Vector3d p_W = surface.mesh.vertices[i].cast<double>();
    const Eigen::Array3d at = ((p_W - low_W_) / voxel_).array().floor();
    if ((at < 0.0).any() || (at >= size_.cast<double>().array()).any()) continue;
    const std::size_t index = index_of(at.cast<int>());
    if (notes_[index] < 0) {
      note(index, static_cast<std::int32_t>(qualities_.size()));
      qualities_.push_back(0.0F);
      counts.push_back(0.0F);
    }
    const double whole = at_border[i] != 0 ? 0.0 : 1.0;
    qualities_[notes_[index]] +=
        static_cast<float>(config.lambda * whole + (1.0 - config.lambda) * surface.density[i]);
    counts[notes_[index]] += 1.0F;
  }
  for (std::size_t i = 0; i < qualities_.size(); ++i) qualities_[i] /= counts[i];

  // Trends: the nearest to each unknown voxel around them.
  if (trends.empty()) return;
  std::vector<Vector3d> points_W;
  for (const SurfaceTrend& trend : trends) points_W.push_back(trend.p_W);
  const geometry::KdTree tree(points_W);
  const double far = kDecays * config.trend_decay_m;
  Eigen::AlignedBox3d around;
  for (const Vector3d& p_W : points_W) around.extend(p_W);
  const Vector3i low =
      ((around.min() - low_W_).array() / voxel_ - far / voxel_).floor().max(0.0).cast<int>();
  const Vector3i high = ((around.max() - low_W_).array() / voxel_ + far / voxel_)
                            .floor()
                            .min(size_.cast<double>().array() - 1.0)
                            .cast<int>();
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const std::size_t index = index_of({x, y, z});
        if (cells_[index] != kBit) continue;  // known, or unknown with mesh in it
        const Vector3d center_W = low_W_ + (Vector3d(x, y, z) + Vector3d::Constant(0.5)) * voxel_;
        if (plane_W.HeightOf(center_W) < 0.0) continue;
        const auto nearest = tree.Nearest(center_W, far);
        if (!nearest) continue;
        const double distance = std::sqrt(nearest->squared_distance);
        note(index, ~static_cast<std::int32_t>(trends_.size()));
        trends_.push_back({trends[nearest->index].normal_W.cast<float>(),
                           static_cast<float>(std::exp(-distance / config.trend_decay_m))});
      }
    }
  }
}

ScanGain ScanGainField::Measure(const geometry::CameraModel& camera, const Pose& X_WC) const {
  ScanGain gain;
  const Vector3d from = (X_WC.translation() - low_W_) / voxel_;
  const double min_cosine = std::cos(config_.max_incidence_deg * std::numbers::pi / 180.0);
  const std::array<std::int64_t, 3> step = {1, size_.x(),
                                            static_cast<std::int64_t>(size_.x()) * size_.y()};
  double quality = 0.0;
  std::int64_t met = 0;
  std::int64_t rays = 0;
  const int most_unknown = static_cast<int>(std::floor(config_.unknown_m / voxel_));
  std::vector<float> shown(trends_.size(), 0.0F);  // chance that the surface in it is seen
  const double middle = 0.5 * (config_.stride - 1);
  for (double v = middle; v < camera.height; v += config_.stride) {
    for (double u = middle; u < camera.width; u += config_.stride) {
      ++rays;
      // Amanatides and Woo 1987, in voxels; t is the distance.
      const Vector3d way = X_WC.linear() * camera.Ray(u, v).normalized();
      double t = 0.0;
      double end = config_.max_range_m / voxel_;
      Vector3d inverse;
      for (int axis = 0; axis < 3; ++axis) {
        inverse[axis] =
            std::abs(way[axis]) < 1e-12 ? std::copysign(kNever, way[axis]) : 1.0 / way[axis];
        const double a = -from[axis] * inverse[axis];
        const double b = (size_[axis] - from[axis]) * inverse[axis];
        t = std::max(t, std::min(a, b));
        end = std::min(end, std::max(a, b));
      }
      end -= kRounding;
      if (!(t < end)) continue;
      const Vector3d entry = from + t * way;
      Vector3d next;
      Vector3d per_voxel;
      std::array<std::int64_t, 3> stride{};
      std::int64_t index = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const int at = std::clamp(static_cast<int>(std::floor(entry[axis])), 0, size_[axis] - 1);
        const bool up = inverse[axis] > 0.0;
        next[axis] = (at + (up ? 1 : 0) - from[axis]) * inverse[axis];
        per_voxel[axis] = std::abs(inverse[axis]);
        stride[axis] = up ? step[axis] : -step[axis];
        index += at * step[axis];
      }
      float open = 1.0F;  // the chance that nothing has stopped it so far
      int unknown = 0;    // voxels passed that no trend is near to
      std::int64_t entropy = 0;
      while (true) {
        const Cell cell = cells_[index];
        entropy += cell & kBit;
        if ((cell & kNoted) != 0) {
          const std::int32_t noted = notes_[index];
          if (noted >= 0) {
            quality += qualities_[noted];
            ++met;
          } else if (-trends_[~noted].normal_W.dot(way.cast<float>()) > min_cosine) {
            const float chance = trends_[~noted].chance;
            shown[~noted] = std::max(shown[~noted], open * chance);
            open *= 1.0F - chance;
          }
        } else if (cell == kBit && ++unknown == most_unknown + 1) {
          open *= static_cast<float>(config_.unknown_survival);
        }
        if ((cell & kEnd) != 0) break;
        const int axis =
            next.x() < next.y() ? (next.x() < next.z() ? 0 : 2) : (next.y() < next.z() ? 1 : 2);
        if (next[axis] >= end) break;
        index += stride[axis];
        next[axis] += per_voxel[axis];
      }
      gain.entropy += static_cast<double>(entropy);
    }
  }
  if (rays > 0) {
    gain.entropy *= static_cast<double>(camera.width) * camera.height /
                    (static_cast<double>(kBit) * static_cast<double>(rays));
  }
  for (const float chance : shown) gain.new_surface += chance * voxel_ * voxel_;
  if (met > 0) gain.quality = quality / static_cast<double>(met);
  return gain;
}

double QualityWeight(int scans, const ScanGainConfig& config) {
  const double ratio = scans / config.quality_scans;
  return ratio / (ratio + 1.0);
}

std::vector<double> KriegelUtilities(const std::vector<ScanGain>& gains, int scans,
                                     const ScanGainConfig& config) {
  double most = 0.0;
  for (const ScanGain& gain : gains) most = std::max(most, gain.entropy);
  const double weight = QualityWeight(scans, config);
  std::vector<double> utilities;
  for (const ScanGain& gain : gains) {
    const double exploration = most > 0.0 ? gain.entropy / most : 0.0;
    utilities.push_back((1.0 - weight) * exploration + weight * (1.0 - gain.quality));
  }
  return utilities;
}

}  // namespace secondlook::planning
