#include "lib/world/brick_grid.h"

#include <algorithm>
#include <cmath>

#include "lib/common/error.h"

namespace secondlook::world {
namespace {

constexpr double kMaxBricks = 1 << 24;

/// Bricks from the first, included, to the end, not included.
struct BrickRange {
  Eigen::Vector3i first;
  Eigen::Vector3i count;
};

BrickRange Bricks(const Eigen::AlignedBox3d& box_W, double voxel) {
  if (!(voxel >= 0.0005 && voxel <= 10.0)) {
    Throw<InvalidArgument>("brick grid: voxels of {} m; they must lie in 0.0005..10 m", voxel);
  }
  const Eigen::Vector3d& low = box_W.min();
  const Eigen::Vector3d& high = box_W.max();
  if (!low.allFinite() || !high.allFinite() || !(box_W.sizes().minCoeff() > 0.0)) {
    Throw<InvalidArgument>(
        "brick grid: the box from ({}, {}, {}) to ({}, {}, {}) m must be finite and have a volume",
        low.x(), low.y(), low.z(), high.x(), high.y(), high.z());
  }
  const double edge = voxel * Brick::kEdge;
  const Eigen::Array3d first = (low.array() / edge).floor();
  // A face that lies on a brick's edge but for rounding does not ask for another brick.
  const Eigen::Array3d count = (high.array() / edge - 1e-9).floor() + 1.0 - first;
  if (!(count.prod() <= kMaxBricks) || !(first.abs().maxCoeff() < 1e8)) {
    Throw<InvalidArgument>(
        "brick grid: the box from ({}, {}, {}) to ({}, {}, {}) m is too large for voxels of {} m; "
        "make it smaller or the voxels wider",
        low.x(), low.y(), low.z(), high.x(), high.y(), high.z(), voxel);
  }
  return {first.cast<int>(), count.cast<int>()};
}

}  // namespace

float LogOdds(double probability) {
  return static_cast<float>(std::log(probability / (1.0 - probability)));
}

double Probability(float log_odds) { return 1.0 - 1.0 / (1.0 + std::exp(double{log_odds})); }

BrickGrid::BrickGrid(double voxel_m, const Eigen::AlignedBox3d& box_W) : voxel_(voxel_m) {
  const BrickRange range = Bricks(box_W, voxel_m);
  per_metre_ = 1.0 / voxel_m;
  first_ = range.first;
  count_ = range.count;
  directory_.assign(static_cast<std::size_t>(count_.prod()), -1);
}

Eigen::AlignedBox3d BrickGrid::box_W() const {
  const double edge = voxel_ * Brick::kEdge;
  return {first_.cast<double>() * edge, (first_ + count_).cast<double>() * edge};
}

void BrickGrid::Cover(const Eigen::AlignedBox3d& box_W) {
  const BrickRange wanted = Bricks(box_W, voxel_);
  if (bricks_.empty()) {  // it holds nothing to stay near to
    first_ = wanted.first;
    count_ = wanted.count;
    directory_.assign(static_cast<std::size_t>(count_.prod()), -1);
    return;
  }
  const Eigen::Vector3i end = (first_ + count_).cwiseMax(wanted.first + wanted.count);
  const Eigen::Vector3i first = first_.cwiseMin(wanted.first);
  if (first == first_ && end == first_ + count_) return;
  const double edge = voxel_ * Brick::kEdge;
  BrickGrid larger(voxel_, {(first.cast<double>().array() + 0.25) * edge,
                            (end.cast<double>().array() - 0.25) * edge});
  for (int i = 0; i < directory_size(); ++i) {
    larger.directory_[larger.DirectoryIndex(BrickAt(i))] = directory_[i];
  }
  first_ = larger.first_;
  count_ = larger.count_;
  directory_ = std::move(larger.directory_);
}

Occupancy BrickGrid::At(const Eigen::Vector3d& p_W) const {
  if (!Contains(p_W)) return Occupancy::kUnknown;
  const VoxelKey key = KeyOf(p_W);
  const Brick* brick = Find(DirectoryIndex({key.x() >> 3, key.y() >> 3, key.z() >> 3}));
  return brick == nullptr ? Occupancy::kUnknown : brick->At(Brick::IndexOf(key));
}

std::optional<double> BrickGrid::ProbabilityAt(const Eigen::Vector3d& p_W) const {
  if (!Contains(p_W)) return std::nullopt;
  const VoxelKey key = KeyOf(p_W);
  const Brick* brick = Find(DirectoryIndex({key.x() >> 3, key.y() >> 3, key.z() >> 3}));
  const int index = Brick::IndexOf(key);
  if (brick == nullptr || (brick->known[index >> 6] >> (index & 63) & 1) == 0) return std::nullopt;
  return Probability(brick->log_odds[index]);
}

Brick* BrickGrid::Touch(int directory_index) {
  std::int32_t& slot = directory_[directory_index];
  if (slot < 0) {
    slot = static_cast<std::int32_t>(bricks_.size());
    bricks_.emplace_back();
  }
  return &bricks_[slot];
}

namespace {

void SetVoxel(int index, float log_odds, Brick* brick) {
  const std::uint64_t bit = std::uint64_t{1} << (index & 63);
  brick->log_odds[index] = log_odds;
  brick->known[index >> 6] |= bit;
  if (log_odds >= 0.0F) {
    brick->hit[index >> 6] |= bit;
  } else {
    brick->hit[index >> 6] &= ~bit;
  }
}

void ForgetVoxel(int index, Brick* brick) {
  const std::uint64_t bit = std::uint64_t{1} << (index & 63);
  brick->log_odds[index] = 0.0F;
  brick->known[index >> 6] &= ~bit;
  brick->hit[index >> 6] &= ~bit;
}

}  // namespace

std::pair<Eigen::Vector3i, Eigen::Vector3i> BrickGrid::BricksIn(
    const Eigen::AlignedBox3d& box_W) const {
  const Eigen::Array3d first = first_.cast<double>();
  const Eigen::Array3d end = (first_ + count_).cast<double>();
  const double per_metre = per_metre_ / Brick::kEdge;
  return {(box_W.min().array() * per_metre).floor().max(first).min(end).cast<int>(),
          (box_W.max().array() * per_metre).floor().max(first - 1.0).min(end - 1.0).cast<int>()};
}

/// Calls `change(directory index, voxel's index)` for every voxel whose centre lies in the box.
template <class Change>
void BrickGrid::ChangeBox(const Eigen::AlignedBox3d& box_W, Change change) {
  const Eigen::Array3d bottom = first_key().cast<double>();
  const Eigen::Array3d top = bottom + (count_ * Brick::kEdge).cast<double>().array() - 1.0;
  const VoxelKey low =
      (box_W.min().array() * per_metre_ - 0.5).ceil().max(bottom).min(top + 1.0).cast<int>();
  const VoxelKey high =
      (box_W.max().array() * per_metre_ - 0.5).floor().max(bottom - 1.0).min(top).cast<int>();
  BeginChange();
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        change(DirectoryIndex({x >> 3, y >> 3, z >> 3}), Brick::IndexOf({x, y, z}));
      }
    }
  }
}

void BrickGrid::Fill(const Eigen::AlignedBox3d& box_W, float log_odds) {
  ChangeBox(box_W, [&](int directory_index, int index) {
    Brick* brick = Touch(directory_index);
    SetVoxel(index, log_odds, brick);
    NoteStates(brick);
  });
}

void BrickGrid::Forget(const Eigen::AlignedBox3d& box_W) {
  ChangeBox(box_W, [&](int directory_index, int index) {
    if (Find(directory_index) == nullptr) return;
    Brick* brick = Touch(directory_index);
    ForgetVoxel(index, brick);
    NoteStates(brick);
  });
}

void BrickGrid::SetPoints(const std::vector<Eigen::Vector3d>& points_W, float log_odds) {
  BeginChange();
  for (const Eigen::Vector3d& p_W : points_W) {
    if (!Contains(p_W)) continue;
    const VoxelKey key = KeyOf(p_W);
    Brick* brick = Touch(DirectoryIndex({key.x() >> 3, key.y() >> 3, key.z() >> 3}));
    SetVoxel(Brick::IndexOf(key), log_odds, brick);
    NoteStates(brick);
  }
}

void BrickGrid::SetStanding(const std::vector<VoxelKey>& keys, bool standing) {
  BeginChange();
  for (const VoxelKey& key : keys) {
    if (!ContainsKey(key)) continue;
    Brick* brick = Touch(DirectoryIndex({key.x() >> 3, key.y() >> 3, key.z() >> 3}));
    const int index = Brick::IndexOf(key);
    const std::uint64_t bit = std::uint64_t{1} << (index & 63);
    if (((brick->standing[index >> 6] & bit) != 0) == standing) continue;
    brick->standing[index >> 6] ^= bit;
    NoteStates(brick);
  }
}

}  // namespace secondlook::world
