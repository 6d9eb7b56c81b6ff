#include "lib/planning/cost_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/common/error.h"

namespace secondlook::planning {
namespace {

constexpr double kFar = 1e9;  ///< Squared distance, in cells, where nothing is occupied.

/// The lower envelope of the parabolas (x - i)^2 + line[i], at every i, in place (Felzenszwalb and
/// Huttenlocher 2012, Distance Transforms of Sampled Functions).
void SquaredDistances(std::vector<double>* line) {
  const int n = static_cast<int>(line->size());
  const std::vector<double> f = *line;
  std::vector<int> parabola(n);
  std::vector<double> from(n + 1);
  int last = 0;
  from[0] = -std::numeric_limits<double>::infinity();
  from[1] = std::numeric_limits<double>::infinity();
  for (int i = 1; i < n; ++i) {
    const auto crossing = [&] {
      const int k = parabola[last];
      return ((f[i] + i * i) - (f[k] + k * k)) / (2.0 * (i - k));
    };
    double at = crossing();
    while (at <= from[last]) {
      --last;
      at = crossing();
    }
    ++last;
    parabola[last] = i;
    from[last] = at;
    from[last + 1] = std::numeric_limits<double>::infinity();
  }
  int k = 0;
  for (int i = 0; i < n; ++i) {
    while (from[k + 1] < i) ++k;
    const int d = i - parabola[k];
    (*line)[i] = d * d + f[parabola[k]];
  }
}

}  // namespace

void CostMapConfig::Validate() const {
  if (!(cell_m >= 0.01 && cell_m <= 0.5)) {
    Throw<ConfigError>("cell_m = {} must lie in 0.01..0.5", cell_m);
  }
  if (!(reach_m >= cell_m && reach_m <= 50.0)) {
    Throw<ConfigError>("reach_m = {} must lie in cell_m..50", reach_m);
  }
  const auto check = [](double value, const char* name) {
    if (!(value >= 0.0 && value <= 1.0))
      Throw<ConfigError>("{} = {} must lie in 0..1", name, value);
  };
  check(min_height_m, "min_height_m");
  check(support_margin_m, "support_margin_m");
  check(clearance_m, "clearance_m");
  check(localisation_sigma_m, "localisation_sigma_m");
  if (!(unknown_cost >= 1.0 && unknown_cost <= 1000.0)) {
    Throw<ConfigError>("unknown_cost = {} must lie in 1..1000", unknown_cost);
  }
}

double SafeRadius(const hal::BaseInfo& base, const CostMapConfig& config) {
  return base.radius + config.clearance_m + 2.0 * config.localisation_sigma_m;
}

CostMap::CostMap(const world::VoxelSpace& space, const std::vector<world::SupportPlane>& supports_W,
                 const hal::BaseInfo& base, const Eigen::Vector2d& center_W,
                 const CostMapConfig& config)
    : config_(config), safe_radius_(SafeRadius(base, config)) {
  config_.Validate();
  if (!center_W.allFinite()) {
    Throw<InvalidArgument>("cost map: its centre ({}, {}) m is not finite", center_W.x(),
                           center_W.y());
  }
  if (!(base.radius > 0.0) || !(base.height > config_.min_height_m) ||
      !std::isfinite(base.radius + base.height)) {
    Throw<InvalidArgument>(
        "cost map: base '{}' of radius {} m and height {} m; the radius must be positive and the "
        "height above min_height_m = {} m",
        base.name, base.radius, base.height, config_.min_height_m);
  }
  size_ = 2 * static_cast<int>(std::ceil(config_.reach_m / config_.cell_m));
  origin_W_ = center_W - Eigen::Vector2d::Constant(0.5 * size_ * config_.cell_m);
  const auto cells = static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_);
  occupied_.assign(cells, 0);
  seen_.assign(cells, 0);

  const Eigen::Vector2d end_W = origin_W_ + Eigen::Vector2d::Constant(size_ * config_.cell_m);
  // From below the floor, whose voxels say at least that the place was seen.
  const Eigen::AlignedBox3d band_W(
      Eigen::Vector3d(origin_W_.x(), origin_W_.y(), -config_.min_height_m),
      Eigen::Vector3d(end_W.x(), end_W.y(), base.height));
  const world::BrickGrid& grid = space.surroundings();
  grid.VisitBricks(band_W, [&](const Eigen::Vector3i& at, const world::Brick& brick) {
    // The brick's columns that hold anything in the band: bit x + 8 y, as in a word of the brick.
    std::uint64_t seen = 0;
    std::uint64_t blocked = 0;
    for (int z = 0; z < world::Brick::kEdge; ++z) {
      const double bottom = (world::Brick::kEdge * at.z() + z) * grid.voxel();
      const double top = bottom + grid.voxel();
      if (top > band_W.min().z() && bottom < band_W.max().z()) seen |= ~brick.Unknown(z);
      if (top > config_.min_height_m && bottom < base.height) blocked |= brick.Occupied(z);
    }
    for (int column = 0; column < 64; ++column) {
      if ((seen >> column & 1) == 0) continue;
      const Eigen::Vector2i key =
          world::Brick::kEdge * at.head<2>() + Eigen::Vector2i(column & 7, column >> 3);
      MarkColumn(key.cast<double>() * grid.voxel(), grid.voxel(), (blocked >> column & 1) != 0);
    }
  });

  for (const world::SupportPlane& support_W : supports_W) {
    for (const Eigen::Vector3d& corner_W : support_W.corners_A) {
      if (!corner_W.allFinite()) {
        Throw<InvalidArgument>("cost map: a corner of a support surface is not finite");
      }
    }
    for (int y = 0; y < size_; ++y) {
      for (int x = 0; x < size_; ++x) {
        const Eigen::Vector2d p_W = CenterOf({x, y});
        const Eigen::Vector3d on_plane_W(p_W.x(), p_W.y(), support_W.corners_A[0].z());
        if (support_W.Covers(on_plane_W, config_.support_margin_m)) occupied_[Index({x, y})] = 1;
      }
    }
  }
  ComputeClearance();
}

/// Enters the square above the floor with the lowest corner `p_W` and `edge` [m].
void CostMap::MarkColumn(const Eigen::Vector2d& p_W, double edge, bool blocked) {
  // A hair inside, so that a voxel which ends on a cell's edge does not count for the next.
  const Eigen::Vector2d hair = Eigen::Vector2d::Constant(0.5e-6 * edge);
  const Cell low = CellOf(p_W + hair).cwiseMax(0);
  const Cell high = CellOf(p_W + Eigen::Vector2d::Constant(edge) - hair).cwiseMin(size_ - 1);
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) {
      seen_[Index({x, y})] = 1;
      if (blocked) occupied_[Index({x, y})] = 1;
    }
  }
}

void CostMap::Block(const Eigen::Vector2d& p_W, double radius) {
  if (!p_W.allFinite() || !std::isfinite(radius)) {
    Throw<InvalidArgument>("cost map: a disc of {} m around ({}, {}) m is not finite", radius,
                           p_W.x(), p_W.y());
  }
  const double reach = radius + 0.5 * config_.cell_m;  // cells that it touches
  const Cell middle = CellOf(p_W);
  if (Contains(middle)) occupied_[Index(middle)] = 1;
  for (int y = 0; y < size_; ++y) {
    for (int x = 0; x < size_; ++x) {
      if ((CenterOf({x, y}) - p_W).norm() <= reach) occupied_[Index({x, y})] = 1;
    }
  }
  ComputeClearance();
}

CostMap::Cell CostMap::CellOf(const Eigen::Vector2d& p_W) const {
  const Eigen::Array2d cells = ((p_W - origin_W_) / config_.cell_m).array().floor();
  return cells.max(-1.0).min(size_).cast<int>();
}

Eigen::Vector2d CostMap::CenterOf(const Cell& cell) const {
  return origin_W_ + (cell.cast<double>() + Eigen::Vector2d::Constant(0.5)) * config_.cell_m;
}

void CostMap::ComputeClearance() {
  clearance_.resize(occupied_.size());
  for (std::size_t i = 0; i < occupied_.size(); ++i) clearance_[i] = occupied_[i] != 0 ? 0.0 : kFar;
  std::vector<double> line(size_);
  for (int y = 0; y < size_; ++y) {
    for (int x = 0; x < size_; ++x) line[x] = clearance_[Index({x, y})];
    SquaredDistances(&line);
    for (int x = 0; x < size_; ++x) clearance_[Index({x, y})] = line[x];
  }
  for (int x = 0; x < size_; ++x) {
    for (int y = 0; y < size_; ++y) line[y] = clearance_[Index({x, y})];
    SquaredDistances(&line);
    for (int y = 0; y < size_; ++y) clearance_[Index({x, y})] = line[y];
  }
  for (double& clearance : clearance_) {
    clearance = std::max(0.0, std::sqrt(clearance) - 0.5) * config_.cell_m;
  }
}

}  // namespace secondlook::planning
