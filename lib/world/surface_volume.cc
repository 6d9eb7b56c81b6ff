#include "lib/world/surface_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>

#include <openvdb/Types.h>
#include <openvdb/tree/Tree.h>
#include <openvdb/tree/ValueAccessor.h>

#include "lib/common/check_range.h"
#include "lib/common/error.h"

namespace secondlook::world {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using openvdb::Coord;

/// Where in a list the value of a voxel stands; kNone: nowhere.
using IndexTree = openvdb::tree::Tree4<std::int32_t, 5, 4, 3>::Type;
using ConstIndices = openvdb::tree::ValueAccessor<const IndexTree>;
constexpr std::int32_t kNone = -1;

/// What is known of the surface at the centre of a voxel.
struct Sample {
  float distance{};  ///< Times weight; > 0 in front of the surface [m].
  float weight{};
  float points{};                    ///< That spoke of it.
  float colored{};                   ///< Weight of those that had a colour.
  Vector3f color{Vector3f::Zero()};  ///< Times weight.
  bool hit{};                        ///< A point lies in it.

  float Distance() const { return distance / weight; }
};

/// Corner k of a cell lies so many voxels from its first.
constexpr std::array<std::array<int, 3>, 8> kCorners = {
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}};

/// The edges of a cell, by their corners.
constexpr std::array<std::array<int, 2>, 12> kEdges = {{{0, 1},
                                                        {2, 3},
                                                        {4, 5},
                                                        {6, 7},
                                                        {0, 2},
                                                        {1, 3},
                                                        {4, 6},
                                                        {5, 7},
                                                        {0, 4},
                                                        {1, 5},
                                                        {2, 6},
                                                        {3, 7}}};

Coord Corner(const Coord& cell, int k) {
  return cell.offsetBy(kCorners[k][0], kCorners[k][1], kCorners[k][2]);
}

Vector3f Offset(int k) {
  return {static_cast<float>(kCorners[k][0]), static_cast<float>(kCorners[k][1]),
          static_cast<float>(kCorners[k][2])};
}

Coord VoxelOf(const Vector3d& voxels) {
  return {static_cast<int>(std::floor(voxels.x())), static_cast<int>(std::floor(voxels.y())),
          static_cast<int>(std::floor(voxels.z()))};
}

/// The surface within a cell.
struct CellVertex {
  Vector3f at{Vector3f::Zero()};  ///< From the cell's first corner [voxels].
  Vector3f gradient{Vector3f::Zero()};
  Vector3f color{Vector3f::Zero()};
  float colored{};
};

using CornerSamples = std::array<const Sample*, 8>;

/// Empty when the surface does not pass the cell.
std::optional<CellVertex> VertexOf(const CornerSamples& corners) {
  int inside = 0;
  for (const Sample* corner : corners) inside += corner->distance < 0.0F ? 1 : 0;
  if (inside == 0 || inside == 8) return std::nullopt;
  CellVertex vertex;
  float crossings = 0.0F;
  for (const auto& [a, b] : kEdges) {
    const float from = corners[a]->Distance();
    const float to = corners[b]->Distance();
    vertex.gradient += (to - from) * (Offset(b) - Offset(a));
    if ((from < 0.0F) == (to < 0.0F)) continue;
    vertex.at += Offset(a) + from / (from - to) * (Offset(b) - Offset(a));
    crossings += 1.0F;
  }
  vertex.at /= crossings;
  for (const Sample* corner : corners) {
    vertex.color += corner->color;
    vertex.colored += corner->colored;
  }
  return vertex;
}

/// The voxels of a ball of `radius` voxels around the middle one.
std::vector<Coord> Ball(double radius) {
  std::vector<Coord> ball;
  const int reach = static_cast<int>(std::ceil(radius));
  for (int z = -reach; z <= reach; ++z) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        if (x * x + y * y + z * z <= radius * radius) ball.emplace_back(x, y, z);
      }
    }
  }
  return ball;
}

}  // namespace

void SurfaceConfig::Validate() const {
  CheckRange(voxel_m, 1e-4, 0.1, "voxel_m");
  CheckRange(before_voxels, 1.0, 20.0, "before_voxels");
  CheckRange(behind_voxels, 1.0, 20.0, "behind_voxels");
  CheckRange(max_incidence_deg, 10.0, 89.0, "max_incidence_deg");
  CheckRange(min_points, 1, 1000, "min_points");
  CheckRange(density_voxels, 1.0, 10.0, "density_voxels");
}

struct SurfaceVolume::Storage {
  IndexTree indices{kNone};
  std::vector<Sample> samples;

  /// Null when the voxel is not measured by at least `points`.
  const Sample* Find(const ConstIndices& accessor, const Coord& voxel, float points) const {
    const std::int32_t index = accessor.getValue(voxel);
    return index != kNone && samples[index].points >= points ? &samples[index] : nullptr;
  }
};

SurfaceVolume::SurfaceVolume(const SurfaceConfig& config, const Eigen::AlignedBox3d& box_W)
    : config_(config), box_W_(box_W), storage_(std::make_unique<Storage>()) {
  config.Validate();
  if (box_W.isEmpty() || !box_W.min().allFinite() || !box_W.max().allFinite()) {
    Throw<InvalidArgument>("surface volume: its box from ({}, {}, {}) to ({}, {}, {}) m is empty",
                           box_W.min().x(), box_W.min().y(), box_W.min().z(), box_W.max().x(),
                           box_W.max().y(), box_W.max().z());
  }
}

SurfaceVolume::~SurfaceVolume() = default;
SurfaceVolume::SurfaceVolume(SurfaceVolume&&) noexcept = default;
SurfaceVolume& SurfaceVolume::operator=(SurfaceVolume&&) noexcept = default;

int SurfaceVolume::size() const { return static_cast<int>(storage_->samples.size()); }

int SurfaceVolume::Integrate(const RangeScan& scan, const ScanPatches& patches) {
  Check(scan);
  if (patches.of_point.size() != scan.points_W.size()) {
    Throw<InvalidArgument>("surface volume: patches of {} points for a scan of {}",
                           patches.of_point.size(), scan.points_W.size());
  }
  const double voxel = config_.voxel_m;
  const double min_cosine = std::cos(config_.max_incidence_deg * std::numbers::pi / 180.0);
  const double behind = config_.behind_voxels * voxel;
  std::vector<Sample>& samples = storage_->samples;
  openvdb::tree::ValueAccessor<IndexTree> indices(storage_->indices);
  const auto touch = [&](const Coord& at) -> Sample& {
    std::int32_t index = indices.getValue(at);
    if (index == kNone) {
      index = static_cast<std::int32_t>(samples.size());
      samples.emplace_back();
      indices.setValue(at, index);
    }
    return samples[index];
  };
  int used = 0;
  std::size_t line = 0;
  for (std::size_t i = 0; i < scan.points_W.size(); ++i) {
    while (scan.lines[line].end <= static_cast<int>(i)) ++line;
    const Vector3d& p_W = scan.points_W[i];
    if (!box_W_.contains(p_W)) continue;
    const Vector3d& normal_W = patches.patches[patches.of_point[i]].normal_W;
    const double cosine = normal_W.dot((scan.lines[line].p_WS - p_W).normalized());
    if (cosine < min_cosine) continue;
    ++used;
    const double sigma_mm = 1000.0 * scan.sigmas[i];
    const auto weight = static_cast<float>(cosine / (sigma_mm * sigma_mm));
    const auto tell = [&](const Coord& at) {
      const Vector3d center_W = Vector3d(at.x() + 0.5, at.y() + 0.5, at.z() + 0.5) * voxel;
      const double distance = normal_W.dot(center_W - p_W);
      const double fade = distance < -voxel ? (distance + behind + voxel) / behind : 1.0;
      if (fade <= 0.0) return;
      Sample& sample = touch(at);
      const auto w = static_cast<float>(weight * fade);
      sample.distance += w * static_cast<float>(distance);
      sample.weight += w;
      sample.points += 1.0F;
      if (scan.colors.empty()) return;
      sample.color += w * scan.colors[i];
      sample.colored += w;
    };
    // Along the normal, layer by layer of its main axis, the four voxels around it in each.
    int axis = 0;
    normal_W.cwiseAbs().maxCoeff(&axis);
    const Vector3d at = p_W / voxel;
    const double steep = std::abs(normal_W[axis]);
    const Vector3d slope = normal_W / normal_W[axis];
    const bool up = normal_W[axis] > 0.0;
    const double low = (up ? config_.behind_voxels : config_.before_voxels) * steep;
    const double high = (up ? config_.before_voxels : config_.behind_voxels) * steep;
    const int last = static_cast<int>(std::floor(at[axis] + high - 0.5));
    for (int k = static_cast<int>(std::ceil(at[axis] - low - 0.5)); k <= last; ++k) {
      const Vector3d middle = at + (k + 0.5 - at[axis]) * slope;
      Coord first = VoxelOf(middle - Vector3d::Constant(0.5));
      first[axis] = k;
      for (int beside = 0; beside < 4; ++beside) {
        Coord one = first;
        one[(axis + 1) % 3] += beside & 1;
        one[(axis + 2) % 3] += beside >> 1;
        tell(one);
      }
    }
    touch(VoxelOf(at)).hit = true;
  }
  return used;
}

PartialMesh SurfaceVolume::Extract() const {
  PartialMesh result;
  result.mesh.materials.emplace_back();
  const double voxel = config_.voxel_m;
  const auto min_points = static_cast<float>(config_.min_points);
  const std::vector<Sample>& samples = storage_->samples;
  const ConstIndices indices(storage_->indices);

  // A vertex in each cell that the surface passes; a cell is named by its first voxel.
  struct Cell {
    Coord at;
    CellVertex vertex;
    std::array<bool, 4> inside{};  // of its first voxel and the next along each axis
  };
  std::vector<Cell> cells;
  std::vector<int> cell_of(samples.size(), kNone);
  for (auto it = storage_->indices.cbeginValueOn(); it; ++it) {
    const Coord at = it.getCoord();
    CornerSamples corners{};
    bool measured = true;
    for (int k = 0; k < 8 && measured; ++k) {
      corners[k] = storage_->Find(indices, Corner(at, k), min_points);
      measured = corners[k] != nullptr;
    }
    if (!measured) continue;
    const std::optional<CellVertex> vertex = VertexOf(corners);
    if (!vertex) continue;
    cell_of[it.getValue()] = static_cast<int>(cells.size());
    const auto inside = [&](int k) { return corners[k]->distance < 0.0F; };
    cells.push_back({at, *vertex, {inside(0), inside(1), inside(2), inside(4)}});
  }

  // A square across each edge of voxels along which the sign changes, between its four cells.
  const auto cell_at = [&](const Coord& at) {
    const std::int32_t index = indices.getValue(at);
    return index == kNone ? kNone : cell_of[index];
  };
  std::vector<std::array<int, 4>> squares;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    for (int axis = 0; axis < 3; ++axis) {
      const bool from_inside = cells[c].inside[0];
      if (from_inside == cells[c].inside[1 + axis]) continue;
      Coord b = cells[c].at;
      Coord d = cells[c].at;
      b[(axis + 1) % 3] -= 1;
      d[(axis + 2) % 3] -= 1;
      Coord diagonal = b;
      diagonal[(axis + 2) % 3] -= 1;
      std::array<int, 4> square = {static_cast<int>(c), cell_at(b), cell_at(diagonal), cell_at(d)};
      if (std::find(square.begin(), square.end(), kNone) != square.end()) continue;
      if (!from_inside) std::swap(square[1], square[3]);  // seen from the front
      squares.push_back(square);
    }
  }

  std::vector<int> vertex_of(cells.size(), kNone);
  for (const std::array<int, 4>& square : squares) {
    for (const int c : square) vertex_of[c] = 0;
  }
  const bool colored = std::any_of(samples.begin(), samples.end(),
                                   [](const Sample& sample) { return sample.colored > 0.0F; });
  const std::vector<Coord> ball = Ball(config_.density_voxels);
  const double disc = std::numbers::pi * config_.density_voxels * config_.density_voxels;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (vertex_of[c] == kNone) continue;
    const Cell& cell = cells[c];
    vertex_of[c] = static_cast<int>(result.mesh.vertices.size());
    const Vector3f within = cell.vertex.at + Vector3f::Constant(0.5F);
    const Vector3f at(static_cast<float>(cell.at.x()), static_cast<float>(cell.at.y()),
                      static_cast<float>(cell.at.z()));
    result.mesh.vertices.emplace_back((at + within) * static_cast<float>(voxel));
    const Vector3f normal = cell.vertex.gradient.normalized();
    result.normals.push_back(normal);
    if (colored) {
      result.mesh.vertex_colors.emplace_back(cell.vertex.color /
                                             std::max(cell.vertex.colored, 1e-9F));
    }
    const Coord middle = cell.at + VoxelOf(within.cast<double>());
    int hits = 0;
    for (const Coord& offset : ball) {
      const std::int32_t index = indices.getValue(middle + offset);
      hits += index != kNone && samples[index].hit ? 1 : 0;
    }
    // A plane meets |nx| + |ny| + |nz| voxels on every area of a voxel's face.
    const double most = disc * normal.lpNorm<1>();
    result.density.push_back(static_cast<float>(std::min(1.0, hits / most)));
  }
  for (const std::array<int, 4>& square : squares) {
    const auto v = [&](int k) { return vertex_of[square[k]]; };
    result.mesh.triangles.emplace_back(v(0), v(1), v(2));
    result.mesh.triangles.emplace_back(v(0), v(2), v(3));
  }
  result.mesh.triangle_material.assign(result.mesh.triangles.size(), 0);
  return result;
}

}  // namespace secondlook::world
