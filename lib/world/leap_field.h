#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lib/world/brick_grid.h"

namespace secondlook::world {

/// What a leap must not cross.
enum class Leap {
  kToOccupied,  ///< Only what is occupied ends it: free and unknown are one.
  kToOther      ///< Any other state ends it.
};

/// How far a ray may leap: for every voxel of a grid its state and the cube around it in which
/// nothing ends a leap. Kept beside the grid and brought up to date brick by brick: a change
/// reaches no farther than the bricks around it. In a region of whole bricks that agree the cube is
/// measured in bricks, elsewhere in voxels, up to kMaxReach. Threading: At() from any number of
/// threads.
class LeapField {
 public:
  /// What ends a leap is looked for less far away than this, in voxels.
  static constexpr int kMaxReach = 8;

  /// Follows the changes of `grid` since the last call, or takes it anew when it was not this grid
  /// or has grown. Returns how many bricks it computed.
  int Refresh(const BrickGrid& grid);

  /// Around one voxel.
  struct Cube {
    Occupancy state{};  ///< Of the voxel.
    int reach{};        ///< No voxel nearer than this ends the leap (Chebyshev distance), …
    int bits{};         ///< … or no brick, when it is Brick::kBits and not 0.
  };
  /// What lies out of the grid ends no leap. @pre `voxel`, counted from the grid's first, lies in
  /// it.
  template <Leap leap>
  Cube At(const Eigen::Vector3i& voxel) const {
    const Cell& cell =
        cells_[((voxel.z() >> 3) * count_.y() + (voxel.y() >> 3)) * count_.x() + (voxel.x() >> 3)];
    const int bricks = leap == Leap::kToOther ? cell.to_other : cell.to_occupied;
    if (bricks > 1) return {cell.state, bricks, Brick::kBits};
    const std::uint8_t code = voxels_[cell.slot][Brick::IndexOf(voxel)];
    const Occupancy state = code >> 4 == 0           ? Occupancy::kOccupied
                            : (code & kUnknown) != 0 ? Occupancy::kUnknown
                                                     : Occupancy::kFree;
    return {state, leap == Leap::kToOther ? (code >> 1 & 7) + 1 : code >> 4, 0};
  }

  std::size_t memory() const {
    return cells_.capacity() * sizeof(Cell) + voxels_.capacity() * Brick::kVoxels;
  }

 private:
  /// A brick of the grid.
  struct Cell {
    std::int32_t slot{-1};                 ///< Of its voxels; -1: none needed yet.
    Occupancy state{Occupancy::kUnknown};  ///< Of all its voxels, when `uniform`.
    bool uniform{true};
    bool clear{true};             ///< None of its voxels is occupied.
    std::uint8_t to_other{1};     ///< Bricks nearer than this are uniform in the same state …
    std::uint8_t to_occupied{1};  ///< … or clear.
  };
  /// A voxel: kUnknown | (reach to another state - 1) << 1 | reach to an occupied one << 4.
  static constexpr std::uint8_t kUnknown = 1;
  using Codes = std::array<std::uint8_t, Brick::kVoxels>;

  std::vector<int> WithNeighbours(const std::vector<int>& bricks) const;
  void MeasureBricks();
  void MeasureVoxels(const BrickGrid& grid, const std::vector<int>& bricks);

  Eigen::Vector3i first_{Eigen::Vector3i::Zero()};
  Eigen::Vector3i count_{Eigen::Vector3i::Zero()};
  std::uint64_t revision_{};  ///< Of the grid when it was last followed.
  std::vector<Cell> cells_;   ///< In the grid's directory order.
  std::vector<Codes> voxels_;
};

}  // namespace secondlook::world
