#pragma once

#include <array>
#include <map>
#include <vector>

#include "lib/world/voxel_space.h"

#include "second_look/occupancy_block_t.hpp"

namespace secondlook::apps {

/// Finds which blocks of 8 x 8 x 8 voxels have changed since the last call.
class OccupancyChanges {
 public:
  /// The blocks in `box_W` that are not as they were, ordered by index.
  std::vector<second_look::occupancy_block_t> Since(const world::VoxelSpace& space,
                                                    const Eigen::AlignedBox3d& box_W);

 private:
  using Index = std::array<std::int32_t, 3>;
  struct Cells {
    std::array<std::uint8_t, 64> free{};
    std::array<std::uint8_t, 64> occupied{};
    bool operator==(const Cells&) const = default;
  };

  std::map<Index, Cells> told_;
};

}  // namespace secondlook::apps
