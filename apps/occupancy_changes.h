#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "lib/world/brick_grid.h"

#include "second_look/occupancy_block_t.hpp"

namespace secondlook::apps {

/// Finds which bricks of a map have other states than at the last call.
class OccupancyChanges {
 public:
  /// The bricks of `grid` in which any voxel is not as it was told, ordered by index. The grid may
  /// be another one than last time, with the same voxels.
  std::vector<second_look::occupancy_block_t> Since(const world::BrickGrid& grid);

 private:
  using Index = std::array<std::int32_t, 3>;
  struct Cells {
    std::array<std::uint8_t, 64> free{};
    std::array<std::uint8_t, 64> occupied{};
    bool operator==(const Cells&) const = default;
  };

  static Cells CellsOf(const world::Brick& brick);

  std::map<Index, Cells> told_;
};

}  // namespace secondlook::apps
