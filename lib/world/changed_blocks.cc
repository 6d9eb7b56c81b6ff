#include "lib/world/changed_blocks.h"

#include <cmath>

namespace secondlook::world {
namespace {

std::int8_t Percent(const Brick& brick, int index) {
  if ((brick.standing[index >> 6] >> (index & 63) & 1) != 0) return 100;
  if (brick.At(index) == Occupancy::kUnknown) return Block::kUnknownCell;
  return static_cast<std::int8_t>(std::lround(100.0 * Probability(brick.log_odds[index])));
}

}  // namespace

std::vector<Block> ChangedBlocks(const BrickGrid& grid, std::uint64_t revision) {
  std::vector<Block> blocks;
  for (int i = 0; i < grid.directory_size(); ++i) {
    const Brick* brick = grid.Find(i);
    if (brick == nullptr || brick->revision <= revision) continue;
    Block block{grid.BrickAt(i), brick->revision, {}};
    for (int v = 0; v < Brick::kVoxels; ++v) block.cells[v] = Percent(*brick, v);
    blocks.push_back(block);
  }
  return blocks;
}

}  // namespace secondlook::world
