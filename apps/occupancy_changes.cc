#include "apps/occupancy_changes.h"

#include <algorithm>
#include <cmath>

namespace secondlook::apps {

std::vector<second_look::occupancy_block_t> OccupancyChanges::Since(
    const world::VoxelSpace& space, const Eigen::AlignedBox3d& box_W) {
  const double edge = space.config().voxel_m;
  std::map<Index, Cells> now;
  space.Visit(box_W, [&](const world::Voxel& cube) {
    const auto n = static_cast<int>(std::lround(cube.size / edge));  // voxels along its edge
    std::array<int, 3> first;
    for (int a = 0; a < 3; ++a) {
      first[a] = static_cast<int>(std::lround((cube.center_W[a] - cube.size / 2.0) / edge));
    }
    const bool occupied = cube.probability >= 0.5;
    for (int z = first[2]; z < first[2] + n; ++z) {
      for (int y = first[1]; y < first[1] + n; ++y) {
        for (int x = first[0]; x < first[0] + n; ++x) {
          Cells& cells = now[{x >> 3, y >> 3, z >> 3}];
          const int bit = (x & 7) + 8 * (y & 7) + 64 * (z & 7);
          (occupied ? cells.occupied : cells.free)[bit >> 3] |=
              static_cast<std::uint8_t>(1 << (bit & 7));
        }
      }
    }
  });
  for (const auto& [index, cells] : told_) now.try_emplace(index);  // all unknown again
  std::vector<second_look::occupancy_block_t> changed;
  for (const auto& [index, cells] : now) {
    const auto before = told_.find(index);
    if (before == told_.end() ? cells == Cells{} : before->second == cells) continue;
    second_look::occupancy_block_t& block = changed.emplace_back();
    std::copy(index.begin(), index.end(), block.index);
    std::copy(cells.free.begin(), cells.free.end(), block.free);
    std::copy(cells.occupied.begin(), cells.occupied.end(), block.occupied);
  }
  told_ = std::move(now);
  return changed;
}

}  // namespace secondlook::apps
