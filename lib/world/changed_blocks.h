#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lib/world/brick_grid.h"

namespace secondlook::world {

/// A brick as others are told of it.
struct Block {
  static constexpr std::int8_t kUnknownCell = -1;

  Eigen::Vector3i index{Eigen::Vector3i::Zero()};  ///< Its lowest corner is 8 x voxel x index in W.
  std::uint64_t revision{};                        ///< Of the grid, when it changed last.
  /// [8 x 8 x 8], x running fastest: how probably occupied in percent, 0 … 100; -1: unknown.
  std::array<std::int8_t, Brick::kVoxels> cells{};
};

/// The bricks that changed after the grid had `revision`, with what they hold now, in directory
/// order. 0: all that hold anything. A receiver that keeps the grid's revision() and asks with it
/// the next time misses nothing.
std::vector<Block> ChangedBlocks(const BrickGrid& grid, std::uint64_t revision);

}  // namespace secondlook::world
