#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace secondlook::world {

/// What is known of a place. Free and occupied are decided at probability 0.5.
enum class Occupancy : std::uint8_t { kFree, kOccupied, kUnknown };

/// A voxel, by how many voxels it lies from the origin of W along each axis: it holds the points
/// with floor(p_W / voxel) = key. Divided by 8 and rounded down it is the index of its brick.
using VoxelKey = Eigen::Vector3i;

/// One bit for each voxel of a brick: bit x + 8 y of word z.
using BrickMask = std::array<std::uint64_t, 8>;

/// log(p / (1 - p)), in single precision as OctoMap has it.
float LogOdds(double probability);
/// The probability that has these log-odds.
double Probability(float log_odds);

/// 8 x 8 x 8 voxels. The voxel (x, y, z) has the index x + 8 y + 64 z.
struct Brick {
  static constexpr int kBits = 3;
  static constexpr int kEdge = 1 << kBits;
  static constexpr int kVoxels = kEdge * kEdge * kEdge;

  std::array<float, kVoxels> log_odds{};  ///< Of being occupied, by measurement; 0: none.
  BrickMask known{};                      ///< Measured.
  BrickMask hit{};                        ///< Measured and rather occupied than free.
  BrickMask standing{};                   ///< Part of a model that stands there, measured or not.
  std::uint64_t revision{};               ///< Of the grid, when anything in it changed last.
  std::uint64_t state_revision{};         ///< … and when a voxel went from one state to another.

  std::uint64_t Occupied(int z) const { return hit[z] | standing[z]; }
  std::uint64_t Free(int z) const { return known[z] & ~Occupied(z); }
  std::uint64_t Unknown(int z) const { return ~(known[z] | standing[z]); }

  /// The voxel's index from its key.
  static int IndexOf(const VoxelKey& key) {
    return (key.x() & 7) | (key.y() & 7) << 3 | (key.z() & 7) << 6;
  }
  Occupancy At(int index) const {
    const int z = index >> 6;
    const std::uint64_t bit = std::uint64_t{1} << (index & 63);
    if ((Occupied(z) & bit) != 0) return Occupancy::kOccupied;
    return (known[z] & bit) != 0 ? Occupancy::kFree : Occupancy::kUnknown;
  }
};

/// Probabilities of occupancy, as log-odds, in a box of space: a dense directory of bricks, made as
/// they are needed. Every change has a revision, so that what is derived from the grid or sent to
/// others follows the changed bricks alone. Points are in frame W [m]. A copy is independent.
/// Threading: queries from any number of threads; nothing else at the same time.
class BrickGrid {
 public:
  /// An unknown grid over `box_W`, grown to whole bricks.
  /// @throws InvalidArgument for a voxel that is not in 0.0005..10 m, or a box that is empty, not
  /// finite, without a volume, or of more than 2^24 bricks.
  BrickGrid(double voxel_m, const Eigen::AlignedBox3d& box_W);

  double voxel() const { return voxel_; }  ///< Edge [m].
  Eigen::AlignedBox3d box_W() const;

  /// Makes the grid larger where `box_W` reaches out of it; what it holds stays. A grid that holds
  /// nothing covers `box_W` alone from then on.
  /// @throws InvalidArgument as the constructor.
  void Cover(const Eigen::AlignedBox3d& box_W);

  VoxelKey KeyOf(const Eigen::Vector3d& p_W) const {
    return (p_W * per_metre_).array().floor().cast<int>();
  }
  Eigen::Vector3d CenterOf(const VoxelKey& key) const {
    return (key.cast<double>() + Eigen::Vector3d::Constant(0.5)) * voxel_;
  }
  /// The voxel around the point is in the grid. False for a point that is not finite.
  bool Contains(const Eigen::Vector3d& p_W) const {
    const Eigen::Array3d local = (p_W * per_metre_ - first_key().cast<double>()).array();
    return (local >= 0.0).all() && (local < (count_ * Brick::kEdge).cast<double>().array()).all();
  }

  Occupancy At(const Eigen::Vector3d& p_W) const;
  /// The probability of the voxel by measurement, what stands there left aside; empty: no
  /// measurement.
  std::optional<double> ProbabilityAt(const Eigen::Vector3d& p_W) const;

  /// The lowest brick and how many there are along each axis.
  const Eigen::Vector3i& first_brick() const { return first_; }
  const Eigen::Vector3i& brick_count() const { return count_; }
  VoxelKey first_key() const { return first_ * Brick::kEdge; }

  /// The bricks of the grid in one order, x first, then y, then z.
  int directory_size() const { return static_cast<int>(directory_.size()); }
  int DirectoryIndex(const Eigen::Vector3i& brick) const {
    const Eigen::Vector3i at = brick - first_;
    return (at.z() * count_.y() + at.y()) * count_.x() + at.x();
  }
  Eigen::Vector3i BrickAt(int directory_index) const {
    const int row = directory_index / count_.x();
    return first_ +
           Eigen::Vector3i(directory_index % count_.x(), row % count_.y(), row / count_.y());
  }
  /// Null: unknown throughout.
  const Brick* Find(int directory_index) const {
    const int slot = directory_[directory_index];
    return slot < 0 ? nullptr : &bricks_[slot];
  }

  /// Calls `visit(brick, data)` for the bricks that reach into `box_W` and hold anything, in
  /// directory order.
  template <class Visit>
  void VisitBricks(const Eigen::AlignedBox3d& box_W, Visit visit) const;

  /// Of the last change; 0: none yet.
  std::uint64_t revision() const { return revision_; }
  /// Begins a change: what is written from now on has a new revision.
  void BeginChange() { ++revision_; }
  /// The brick, to be written; made when there is none yet. Whoever writes to it notes what
  /// changed.
  Brick* Touch(int directory_index);
  void NoteValues(Brick* brick) const { brick->revision = revision_; }
  void NoteStates(Brick* brick) const { brick->revision = brick->state_revision = revision_; }

  /// Sets every voxel whose centre lies in `box_W`, as far as the grid reaches, to `log_odds`.
  void Fill(const Eigen::AlignedBox3d& box_W, float log_odds);
  /// Forgets every such voxel: it is unknown again.
  void Forget(const Eigen::AlignedBox3d& box_W);
  /// Sets the voxels around the points, as far as they lie in the grid.
  void SetPoints(const std::vector<Eigen::Vector3d>& points_W, float log_odds);
  /// Lets a model stand in the voxels, or takes it away; keys out of the grid are ignored.
  void SetStanding(const std::vector<VoxelKey>& keys, bool standing);

  /// Bytes that the grid holds.
  std::size_t memory() const {
    return bricks_.capacity() * sizeof(Brick) + directory_.capacity() * sizeof(std::int32_t);
  }

 private:
  bool ContainsKey(const VoxelKey& key) const {
    const VoxelKey local = key - first_key();
    return local.minCoeff() >= 0 && (local.array() < (count_ * Brick::kEdge).array()).all();
  }
  /// The first and last brick that reach into the box.
  std::pair<Eigen::Vector3i, Eigen::Vector3i> BricksIn(const Eigen::AlignedBox3d& box_W) const;
  template <class Change>
  void ChangeBox(const Eigen::AlignedBox3d& box_W, Change change);

  double voxel_;
  double per_metre_;
  Eigen::Vector3i first_;
  Eigen::Vector3i count_;
  std::vector<std::int32_t> directory_;  ///< Index into bricks_; -1: none.
  std::vector<Brick> bricks_;
  std::uint64_t revision_{};
};

template <class Visit>
void BrickGrid::VisitBricks(const Eigen::AlignedBox3d& box_W, Visit visit) const {
  const auto [low, high] = BricksIn(box_W);
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const Eigen::Vector3i brick(x, y, z);
        const Brick* data = Find(DirectoryIndex(brick));
        if (data != nullptr) visit(brick, *data);
      }
    }
  }
}

}  // namespace secondlook::world
