#include "apps/occupancy_changes.h"

#include <algorithm>

namespace secondlook::apps {

/// As occupancy_block_t orders them: 8 bytes a layer, the lowest voxel in the lowest bit.
OccupancyChanges::Cells OccupancyChanges::CellsOf(const world::Brick& brick) {
  Cells cells;
  for (int i = 0; i < 64; ++i) {
    const int z = i >> 3;
    const int shift = 8 * (i & 7);
    cells.free[i] = static_cast<std::uint8_t>(brick.Free(z) >> shift);
    cells.occupied[i] = static_cast<std::uint8_t>(brick.Occupied(z) >> shift);
  }
  return cells;
}

std::vector<second_look::occupancy_block_t> OccupancyChanges::Since(const world::BrickGrid& grid) {
  std::map<Index, Cells> now;
  for (const auto& [index, cells] : told_) now[index] = {};  // unknown again, unless it is there
  for (int i = 0; i < grid.directory_size(); ++i) {
    const world::Brick* brick = grid.Find(i);
    if (brick == nullptr) continue;
    const Eigen::Vector3i at = grid.BrickAt(i);
    now[{at.x(), at.y(), at.z()}] = CellsOf(*brick);
  }
  std::vector<second_look::occupancy_block_t> changed;
  for (const auto& [index, cells] : now) {
    const auto before = told_.find(index);
    if (cells == (before == told_.end() ? Cells{} : before->second)) continue;
    second_look::occupancy_block_t& block = changed.emplace_back();
    std::copy(index.begin(), index.end(), block.index);
    std::copy(cells.free.begin(), cells.free.end(), block.free);
    std::copy(cells.occupied.begin(), cells.occupied.end(), block.occupied);
  }
  told_ = std::move(now);
  return changed;
}

}  // namespace secondlook::apps
