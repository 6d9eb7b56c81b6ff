#include "lib/world/leap_field.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace secondlook::world {
namespace {

using Eigen::Vector3i;

constexpr std::uint64_t kLowX = 0x0101010101010101;  ///< The voxels of a slice with x = 0 …
constexpr std::uint64_t kHighX = kLowX << 7;         ///< … and 7.
constexpr std::uint64_t kAll = ~std::uint64_t{0};

/// Bricks that are grown together, each with its six neighbours among them.
struct Patch {
  static constexpr int kNone = -1;
  std::vector<int> bricks;                    ///< In the grid's directory.
  std::vector<std::array<int, 6>> neighbour;  ///< -x, +x, -y, +y, -z, +z; an index of the patch.
};

Patch MakePatch(const std::vector<int>& bricks, const Vector3i& count) {
  Patch patch{bricks, {}};
  std::vector<int> index(static_cast<std::size_t>(count.prod()), Patch::kNone);
  for (int i = 0; i < static_cast<int>(bricks.size()); ++i) index[bricks[i]] = i;
  for (const int brick : bricks) {
    const int x = brick % count.x();
    const int y = brick / count.x() % count.y();
    const int z = brick / (count.x() * count.y());
    const int row = count.x();
    const int slice = count.x() * count.y();
    patch.neighbour.push_back({x > 0 ? index[brick - 1] : Patch::kNone,
                               x + 1 < count.x() ? index[brick + 1] : Patch::kNone,
                               y > 0 ? index[brick - row] : Patch::kNone,
                               y + 1 < count.y() ? index[brick + row] : Patch::kNone,
                               z > 0 ? index[brick - slice] : Patch::kNone,
                               z + 1 < count.z() ? index[brick + slice] : Patch::kNone});
  }
  return patch;
}

/// Grows the set of voxels in `masks` by one voxel along each axis and diagonally (a cube of three
/// voxels). `spare` is for its own use, of the same size.
void Grow(const Patch& patch, std::vector<BrickMask>* masks, std::vector<BrickMask>* spare) {
  static constexpr BrickMask kEmpty{};
  const int size = static_cast<int>(masks->size());
  const auto at = [&](const std::vector<BrickMask>& set, int brick, int side) -> const BrickMask& {
    const int i = patch.neighbour[brick][side];
    return i == Patch::kNone ? kEmpty : set[i];
  };
  for (int i = 0; i < size; ++i) {  // along x: the bits of a row
    const BrickMask& here = (*masks)[i];
    const BrickMask& low = at(*masks, i, 0);
    const BrickMask& high = at(*masks, i, 1);
    for (int z = 0; z < 8; ++z) {
      (*spare)[i][z] = here[z] | (here[z] & ~kHighX) << 1 | (here[z] & ~kLowX) >> 1 |
                       (low[z] & kHighX) >> 7 | (high[z] & kLowX) << 7;
    }
  }
  for (int i = 0; i < size; ++i) {  // along y: the rows of a word
    const BrickMask& here = (*spare)[i];
    const BrickMask& low = at(*spare, i, 2);
    const BrickMask& high = at(*spare, i, 3);
    for (int z = 0; z < 8; ++z) {
      (*masks)[i][z] = here[z] | here[z] << 8 | here[z] >> 8 | low[z] >> 56 | high[z] << 56;
    }
  }
  for (int i = 0; i < size; ++i) {  // along z: the words
    const BrickMask& here = (*masks)[i];
    (*spare)[i][0] = here[0] | here[1] | at(*masks, i, 4)[7];
    for (int z = 1; z < 7; ++z) (*spare)[i][z] = here[z - 1] | here[z] | here[z + 1];
    (*spare)[i][7] = here[6] | here[7] | at(*masks, i, 5)[0];
  }
  std::swap(*masks, *spare);
}

bool AllSet(const BrickMask& mask) {
  return std::all_of(mask.begin(), mask.end(), [](std::uint64_t word) { return word == kAll; });
}

/// The voxels of a brick, which may be null, for which `part(brick, z)` says so.
template <class Part>
BrickMask MaskOf(const Brick* brick, Part part) {
  static const Brick kUnknownBrick{};
  BrickMask mask;
  for (int z = 0; z < Brick::kEdge; ++z)
    mask[z] = part(brick == nullptr ? kUnknownBrick : *brick, z);
  return mask;
}

std::uint64_t Free(const Brick& brick, int z) { return brick.Free(z); }
std::uint64_t Unknown(const Brick& brick, int z) { return brick.Unknown(z); }
std::uint64_t Clear(const Brick& brick, int z) { return ~brick.Occupied(z); }

}  // namespace

int LeapField::Refresh(const BrickGrid& grid) {
  const bool anew =
      first_ != grid.first_brick() || count_ != grid.brick_count() || grid.revision() < revision_;
  if (anew) {
    first_ = grid.first_brick();
    count_ = grid.brick_count();
    cells_.assign(grid.directory_size(), Cell{});
    voxels_.clear();
  }
  std::vector<int> changed;
  bool bricks_changed = anew;
  for (int i = 0; i < grid.directory_size(); ++i) {
    const Brick* brick = grid.Find(i);
    if (brick == nullptr || (!anew && brick->state_revision <= revision_)) continue;
    changed.push_back(i);
    Cell& cell = cells_[i];
    const Cell before = cell;
    cell.state = brick->At(0);
    cell.clear = AllSet(MaskOf(brick, Clear));
    cell.uniform = cell.clear && (AllSet(MaskOf(brick, Free)) || AllSet(MaskOf(brick, Unknown)));
    bricks_changed |= cell.clear != before.clear || cell.uniform != before.uniform ||
                      (cell.uniform && cell.state != before.state);
  }
  revision_ = grid.revision();
  if (changed.empty() && !anew) return 0;
  if (bricks_changed) MeasureBricks();
  const std::vector<int> touched = WithNeighbours(changed);
  MeasureVoxels(grid, touched);
  return static_cast<int>(touched.size());
}

/// The bricks and those that touch them, ascending.
std::vector<int> LeapField::WithNeighbours(const std::vector<int>& bricks) const {
  std::vector<char> in(cells_.size(), 0);
  for (const int brick : bricks) {
    const int x = brick % count_.x();
    const int y = brick / count_.x() % count_.y();
    const int z = brick / (count_.x() * count_.y());
    for (int dz = std::max(z - 1, 0); dz <= std::min(z + 1, count_.z() - 1); ++dz) {
      for (int dy = std::max(y - 1, 0); dy <= std::min(y + 1, count_.y() - 1); ++dy) {
        for (int dx = std::max(x - 1, 0); dx <= std::min(x + 1, count_.x() - 1); ++dx) {
          in[(dz * count_.y() + dy) * count_.x() + dx] = 1;
        }
      }
    }
  }
  std::vector<int> all;
  for (int i = 0; i < static_cast<int>(in.size()); ++i) {
    if (in[i] != 0) all.push_back(i);
  }
  return all;
}

/// How far bricks reach: the Chebyshev distance to the nearest that differs, by one sweep up and
/// one down over the 26 neighbours. What lies out of the grid differs from nothing.
void LeapField::MeasureBricks() {
  const auto nearer = [](std::uint8_t reach, bool alike, std::uint8_t other) {
    return alike ? std::min<std::uint8_t>(reach, std::max<std::uint8_t>(other, other + 1)) : 1;
  };
  const auto sweep = [&](int x, int y, int z, int sign) {
    Cell& cell = cells_[(z * count_.y() + y) * count_.x() + x];
    if (!cell.clear) return;
    for (int n = 0; n < 13; ++n) {  // the neighbours before it in the order of the sweep
      const int nx = x + sign * (n % 3 - 1);
      const int ny = y + sign * (n / 3 % 3 - 1);
      const int nz = z + sign * (n / 9 - 1);
      if (nx < 0 || ny < 0 || nz < 0 || nx >= count_.x() || ny >= count_.y() || nz >= count_.z()) {
        continue;
      }
      const Cell& other = cells_[(nz * count_.y() + ny) * count_.x() + nx];
      const bool alike = cell.uniform && other.uniform && cell.state == other.state;
      cell.to_other = nearer(cell.to_other, alike, other.to_other);
      cell.to_occupied = nearer(cell.to_occupied, other.clear, other.to_occupied);
    }
  };
  for (Cell& cell : cells_) {
    cell.to_other = cell.uniform ? std::numeric_limits<std::uint8_t>::max() : 1;
    cell.to_occupied = cell.clear ? std::numeric_limits<std::uint8_t>::max() : 1;
  }
  for (int z = 0; z < count_.z(); ++z) {
    for (int y = 0; y < count_.y(); ++y) {
      for (int x = 0; x < count_.x(); ++x) sweep(x, y, z, 1);
    }
  }
  for (int z = count_.z() - 1; z >= 0; --z) {
    for (int y = count_.y() - 1; y >= 0; --y) {
      for (int x = count_.x() - 1; x >= 0; --x) sweep(x, y, z, -1);
    }
  }
}

/// The reaches of each voxel of `bricks`: what ends a leap is grown voxel by voxel until it gets
/// there.
void LeapField::MeasureVoxels(const BrickGrid& grid, const std::vector<int>& bricks) {
  std::vector<int> measured;
  for (const int brick : bricks) {
    if (cells_[brick].to_other > 1) continue;  // never asked voxel by voxel
    if (cells_[brick].slot < 0) {
      cells_[brick].slot = static_cast<std::int32_t>(voxels_.size());
      voxels_.emplace_back();
    }
    measured.push_back(brick);
  }
  const Patch patch = MakePatch(WithNeighbours(measured), count_);
  // What each brick of the patch is written to; null for those around, which only take part.
  std::vector<Codes*> codes(patch.bricks.size(), nullptr);
  for (std::size_t i = 0, m = 0; m < measured.size(); ++i) {
    if (patch.bricks[i] == measured[m]) codes[i] = &voxels_[cells_[measured[m++]].slot];
  }
  for (Codes* brick : codes) {
    if (brick != nullptr) brick->fill(0);
  }
  std::vector<BrickMask> left(patch.bricks.size());  // not reached yet
  std::vector<BrickMask> ends(patch.bricks.size());  // what ends a leap, grown
  std::vector<BrickMask> spare(patch.bricks.size());
  const auto measure = [&](auto part, int last, auto code) {
    for (std::size_t i = 0; i < patch.bricks.size(); ++i) {
      left[i] = MaskOf(grid.Find(patch.bricks[i]), part);
      for (int z = 0; z < Brick::kEdge; ++z) ends[i][z] = ~left[i][z];
    }
    for (int reach = 1; reach <= last; ++reach) {
      if (reach < last) Grow(patch, &ends, &spare);
      const std::uint8_t added = code(reach);
      for (std::size_t i = 0; i < patch.bricks.size(); ++i) {
        if (codes[i] == nullptr) continue;
        for (int z = 0; z < Brick::kEdge; ++z) {
          std::uint64_t reached = reach < last ? left[i][z] & ends[i][z] : left[i][z];
          left[i][z] &= ~reached;
          for (; reached != 0; reached &= reached - 1) {
            (*codes[i])[64 * z + std::countr_zero(reached)] |= added;
          }
        }
      }
    }
  };
  measure(Free, kMaxReach, [](int reach) { return static_cast<std::uint8_t>((reach - 1) << 1); });
  measure(Unknown, kMaxReach,
          [](int reach) { return static_cast<std::uint8_t>(kUnknown | (reach - 1) << 1); });
  measure(Clear, kMaxReach, [](int reach) { return static_cast<std::uint8_t>(reach << 4); });
}

}  // namespace secondlook::world
