#include "lib/world/voxel_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include <octomap/OcTree.h>

#include "lib/common/error.h"
#include "lib/common/files.h"

namespace secondlook::world {
namespace {

using Key = Eigen::Vector3i;

constexpr int kLevels = 16;               ///< Of the octree; level 0 is the voxel.
constexpr int kBrickLevel = 3;            ///< Marks are kept in bricks of 8 x 8 x 8 voxels.
constexpr int kBrick = 1 << kBrickLevel;  ///< Edge of a brick in voxels.
constexpr std::uint8_t kMissed = 1;       ///< A ray passed.
constexpr std::uint8_t kHit = 2;          ///< A ray ended.
constexpr int kKeyMargin = 2768;          ///< Keys kept off the ends of the octree's range.
constexpr int kKeyMin = kKeyMargin;       ///< Smallest key entered.
constexpr int kKeyMax = 65535 - kKeyMargin;

bool InRange(const Key& key) { return key.minCoeff() >= kKeyMin && key.maxCoeff() <= kKeyMax; }

/// The bits of three numbers below 8 interleaved, x lowest: a voxel's place in its brick, in the
/// octree's own order of children.
int MortonIndex(const Key& key) {
  static constexpr std::array<int, 8> kSpread = {0, 1, 8, 9, 64, 65, 72, 73};
  return kSpread[key.x() & 7] | (kSpread[key.y() & 7] << 1) | (kSpread[key.z() & 7] << 2);
}

/// What one image says of the voxels in a box of whole bricks.
class Marks {
 public:
  /// Room for the voxels from `low` to `high`, both included.
  Marks(const Key& low, const Key& high)
      : origin_(low / kBrick), count_(high / kBrick - origin_ + Key::Ones()) {
    const auto bricks = static_cast<std::size_t>(count_.cast<std::int64_t>().prod());
    touched_.assign(bricks, 0);
    marks_.assign(bricks << (3 * kBrickLevel), 0);
  }

  void Add(const Key& key, std::uint8_t mark) {
    const std::size_t brick = BrickIndex(key / kBrick);
    touched_[brick] = 1;
    marks_[(brick << (3 * kBrickLevel)) + static_cast<std::size_t>(MortonIndex(key))] |= mark;
  }

  std::uint8_t At(const Key& key) const {
    return marks_[(BrickIndex(key / kBrick) << (3 * kBrickLevel)) +
                  static_cast<std::size_t>(MortonIndex(key))];
  }

  /// True when a voxel of the cube with the lowest corner `low` and 2^level voxels an edge has one.
  bool Any(const Key& low, int level) const {
    if (level < kBrickLevel) return AnyInBrick(low, level);
    const Key first = (low / kBrick).cwiseMax(origin_);
    const Key last = (low / kBrick + Key::Constant(1 << (level - kBrickLevel)))
                         .cwiseMin(origin_ + count_);  // not included
    for (int z = first.z(); z < last.z(); ++z) {
      for (int y = first.y(); y < last.y(); ++y) {
        for (int x = first.x(); x < last.x(); ++x) {
          if (touched_[BrickIndex({x, y, z})] != 0) return true;
        }
      }
    }
    return false;
  }

 private:
  bool AnyInBrick(const Key& low, int level) const {
    const std::uint8_t* first = &marks_[(BrickIndex(low / kBrick) << (3 * kBrickLevel)) +
                                        static_cast<std::size_t>(MortonIndex(low))];
    return std::any_of(first, first + (1 << (3 * level)), [](std::uint8_t m) { return m != 0; });
  }

  std::size_t BrickIndex(const Key& brick) const {
    const Key at = brick - origin_;
    return (static_cast<std::size_t>(at.z()) * static_cast<std::size_t>(count_.y()) +
            static_cast<std::size_t>(at.y())) *
               static_cast<std::size_t>(count_.x()) +
           static_cast<std::size_t>(at.x());
  }

  Key origin_;  ///< In bricks.
  Key count_;   ///< Bricks along each axis.
  std::vector<std::uint8_t> touched_;
  std::vector<std::uint8_t> marks_;
};

/// A ray that ends in a voxel, or is cut off in it.
struct End {
  Key key;
  bool hit{};

  std::array<int, 4> Order() const { return {key.z(), key.y(), key.x(), hit ? 1 : 0}; }
  friend bool operator<(const End& a, const End& b) { return a.Order() < b.Order(); }
  friend bool operator==(const End& a, const End& b) { return a.Order() == b.Order(); }
};

/// Calls `visit` for each voxel between `from` (included) and the voxel `to` (not included); units
/// are voxels (Amanatides and Woo 1987).
template <class Visit>
void Traverse(const Eigen::Vector3d& from, const Key& to, Visit visit) {
  Key at = from.array().floor().cast<int>();
  const Eigen::Vector3d way = to.cast<double>() + Eigen::Vector3d::Constant(0.5) - from;
  Key step;
  Eigen::Vector3d next;
  Eigen::Vector3d each;
  for (int axis = 0; axis < 3; ++axis) {
    step[axis] = way[axis] > 0.0 ? 1 : -1;
    each[axis] = 1.0 / std::abs(way[axis]);
    const double edge = at[axis] + (step[axis] > 0 ? 1.0 : 0.0);
    next[axis] = way[axis] == 0.0 ? std::numeric_limits<double>::infinity()
                                  : (edge - from[axis]) / way[axis];
  }
  for (int left = (to - at).cwiseAbs().sum(); left > 0; --left) {
    visit(at);
    const int axis =
        next.x() < next.y() ? (next.x() < next.z() ? 0 : 2) : (next.y() < next.z() ? 1 : 2);
    at[axis] += step[axis];
    next[axis] += each[axis];
  }
}

/// The first and last key of the voxels whose centres lie between two points given in voxels, kept
/// in range.
std::pair<Key, Key> KeyRange(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const Eigen::Array3d bottom = Eigen::Array3d::Constant(kKeyMin);
  const Eigen::Array3d top = Eigen::Array3d::Constant(kKeyMax);
  return {(low.array() - 0.5).ceil().max(bottom).min(top + 1.0).cast<int>(),
          (high.array() - 0.5).floor().max(bottom - 1.0).min(top).cast<int>()};
}

void CheckBox(const Eigen::AlignedBox3d& box_W, const char* what) {
  if (box_W.min().allFinite() && box_W.max().allFinite()) return;
  Throw<InvalidArgument>("voxel space: {} from ({}, {}, {}) to ({}, {}, {}) m is not finite", what,
                         box_W.min().x(), box_W.min().y(), box_W.min().z(), box_W.max().x(),
                         box_W.max().y(), box_W.max().z());
}

bool IsBinary(const std::filesystem::path& file) {
  const std::string suffix = file.extension().string();
  if (suffix == ".bt") return true;
  if (suffix == ".ot") return false;
  Throw<ConfigError>("{}: a map ends in .bt or .ot, not in '{}'", file.string(), suffix);
}

}  // namespace

void VoxelSpaceConfig::Validate() const {
  if (!(voxel_m >= 0.001 && voxel_m <= 1.0)) {
    Throw<ConfigError>("voxel_m = {} must lie in 0.001..1", voxel_m);
  }
  if (!(max_range_m > voxel_m && max_range_m <= 100.0)) {
    Throw<ConfigError>("max_range_m = {} must lie in voxel_m..100", max_range_m);
  }
  if (!(hit_probability > 0.5 && hit_probability < 1.0)) {
    Throw<ConfigError>("hit_probability = {} must lie between 0.5 and 1", hit_probability);
  }
  if (!(miss_probability > 0.0 && miss_probability < 0.5)) {
    Throw<ConfigError>("miss_probability = {} must lie between 0 and 0.5", miss_probability);
  }
  if (!(likely_free_below > 0.0 && likely_free_below <= 0.5)) {
    Throw<ConfigError>("likely_free_below = {} must lie in 0..0.5", likely_free_below);
  }
}

/// OctoMap's tree with what it lacks: an update by a whole image in one descent, and a look-up that
/// also says how large the cube is that shares the answer.
class VoxelSpace::Tree : public octomap::OcTree {
 public:
  struct Cube {
    const octomap::OcTreeNode* node{};  ///< Null: unknown.
    int level{};                        ///< 2^level voxels an edge.
  };

  using octomap::OcTree::OcTree;

  Eigen::Vector3d InVoxels(const Eigen::Vector3d& p_W) const {
    return p_W / resolution + Eigen::Vector3d::Constant(tree_max_val);
  }
  Key KeyOf(const Eigen::Vector3d& p_W) const {
    const Eigen::Vector3d voxels = InVoxels(p_W);
    // Far out or NaN: some key out of range.
    if (!(voxels.minCoeff() >= 0.0 && voxels.maxCoeff() < 65536.0)) return Key::Zero();
    return voxels.array().floor().cast<int>();
  }
  Eigen::Vector3d CornerOf(const Key& key) const {
    return (key.cast<double>() - Eigen::Vector3d::Constant(tree_max_val)) * resolution;
  }
  static octomap::OcTreeKey ToOctomap(const Key& key) {
    return {static_cast<octomap::key_type>(key.x()), static_cast<octomap::key_type>(key.y()),
            static_cast<octomap::key_type>(key.z())};
  }

  void Update(const Marks& marks) {
    const bool fresh = root == nullptr;
    if (fresh) {
      root = new octomap::OcTreeNode();
      ++tree_size;
    }
    size_changed = true;
    Update(marks, root, Key::Zero(), kLevels, fresh);
  }

  /// Makes the voxels from `first` to `last`, both included, unknown.
  void Forget(const Key& first, const Key& last) {
    if (root == nullptr || (first.array() > last.array()).any()) return;
    if (Forget(root, Key::Zero(), kLevels, first, last)) clear();
    size_changed = true;
  }

  Cube Find(const Key& key) const {
    const octomap::OcTreeNode* node = root;
    if (node == nullptr) return {nullptr, kLevels};
    for (int level = kLevels; level > 0; --level) {
      if (!nodeHasChildren(node)) return {node, level};
      const int bit = level - 1;
      const auto child = static_cast<unsigned>(
          ((key.x() >> bit) & 1) | ((key.y() >> bit) & 1) << 1 | ((key.z() >> bit) & 1) << 2);
      if (!nodeChildExists(node, child)) return {nullptr, bit};
      node = getNodeChild(node, child);
    }
    return {node, 0};
  }

 private:
  void Update(const Marks& marks, octomap::OcTreeNode* node, const Key& low, int level,
              bool fresh) {
    if (level == 0) {
      updateNodeLogOdds(node, (marks.At(low) & kHit) != 0 ? prob_hit_log : prob_miss_log);
      return;
    }
    const int half = 1 << (level - 1);
    for (int child = 0; child < 8; ++child) {
      const Key child_low = low + half * Key(child & 1, (child >> 1) & 1, (child >> 2) & 1);
      if (!marks.Any(child_low, level - 1)) continue;
      const auto index = static_cast<unsigned>(child);
      bool fresh_child = false;
      if (!nodeChildExists(node, index)) {
        if (!fresh && !nodeHasChildren(node)) {
          expandNode(node);
        } else {
          createNodeChild(node, index);
          fresh_child = true;
        }
        fresh = false;
      }
      Update(marks, getNodeChild(node, index), child_low, level - 1, fresh_child);
    }
    if (!pruneNode(node)) node->updateOccupancyChildren();
  }

  /// True when nothing is left of the cube of `node`, which the caller then drops.
  bool Forget(octomap::OcTreeNode* node, const Key& low, int level, const Key& first,
              const Key& last) {
    const Key high = low + Key::Constant((1 << level) - 1);
    if ((low.array() > last.array()).any() || (high.array() < first.array()).any()) return false;
    if ((low.array() >= first.array()).all() && (high.array() <= last.array()).all()) return true;
    if (!nodeHasChildren(node)) expandNode(node);
    const int half = 1 << (level - 1);
    for (int child = 0; child < 8; ++child) {
      const auto index = static_cast<unsigned>(child);
      if (!nodeChildExists(node, index)) continue;
      const Key child_low = low + half * Key(child & 1, (child >> 1) & 1, (child >> 2) & 1);
      if (Forget(getNodeChild(node, index), child_low, level - 1, first, last)) {
        MakeLeaf(getNodeChild(node, index));
        deleteNodeChild(node, index);
      }
    }
    if (!nodeHasChildren(node)) return true;
    node->updateOccupancyChildren();
    return false;
  }

  /// Drops all that is below `node`. OctoMap frees the array of children only when it prunes, so
  /// the node is given eight equal ones to prune (its deleteNode() leaves the array behind and
  /// fails on the assertion that there is none).
  void MakeLeaf(octomap::OcTreeNode* node) {
    for (unsigned child = 0; child < 8; ++child) {
      if (!nodeChildExists(node, child)) continue;
      MakeLeaf(getNodeChild(node, child));
      deleteNodeChild(node, child);
    }
    for (unsigned child = 0; child < 8; ++child) createNodeChild(node, child);
    pruneNode(node);
  }
};

VoxelSpace::VoxelSpace(const VoxelSpaceConfig& config) : config_(config) {
  config_.Validate();
  tree_ = std::make_unique<Tree>(config_.voxel_m);
  tree_->setProbHit(config_.hit_probability);
  tree_->setProbMiss(config_.miss_probability);
}
VoxelSpace::VoxelSpace(const VoxelSpace& other)
    : config_(other.config_), tree_(std::make_unique<Tree>(*other.tree_)) {
  tree_->setProbHit(config_.hit_probability);  // OctoMap's copy leaves these behind
  tree_->setProbMiss(config_.miss_probability);
}
VoxelSpace& VoxelSpace::operator=(const VoxelSpace& other) {
  *this = VoxelSpace(other);
  return *this;
}
VoxelSpace::VoxelSpace(VoxelSpace&&) noexcept = default;
VoxelSpace& VoxelSpace::operator=(VoxelSpace&&) noexcept = default;
VoxelSpace::~VoxelSpace() = default;

void VoxelSpace::Insert(const cv::Mat& depth, const geometry::CameraModel& camera, const Pose& X_WC,
                        int stride) {
  if (depth.type() != CV_32FC1 || depth.cols != camera.width || depth.rows != camera.height) {
    Throw<InvalidArgument>(
        "voxel space: the depth image is {} x {} px of OpenCV type {}; the camera's is {} x {} px "
        "of type {} (CV_32FC1)",
        depth.cols, depth.rows, depth.type(), camera.width, camera.height, CV_32FC1);
  }
  if (!IsValid(X_WC)) {
    Throw<InvalidArgument>("voxel space: the camera pose X_WC is not finite and rigid");
  }
  if (stride < 1) Throw<InvalidArgument>("voxel space: stride = {} must be at least 1", stride);

  const Eigen::Vector3d from = tree_->InVoxels(X_WC.translation());
  const Key from_key = tree_->KeyOf(X_WC.translation());
  if (!InRange(from_key)) return;
  std::vector<End> ends;
  for (int v = 0; v < depth.rows; v += stride) {
    const auto* row = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; u += stride) {
      const double z = row[u];
      if (!(z > 0.0) || !std::isfinite(z)) continue;
      Eigen::Vector3d p_CQ = camera.Ray(u, v) * z;
      const double range = p_CQ.norm();
      const bool hit = range <= config_.max_range_m;
      if (!hit) p_CQ *= config_.max_range_m / range;
      const Key key = tree_->KeyOf(X_WC * p_CQ);
      if (InRange(key)) ends.push_back({key, hit});
    }
  }
  if (ends.empty()) return;
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());

  Key low = from_key;
  Key high = from_key;
  for (const End& end : ends) {
    low = low.cwiseMin(end.key);
    high = high.cwiseMax(end.key);
  }
  Marks marks(low, high);
  for (const End& end : ends) {
    Traverse(from, end.key, [&](const Key& key) { marks.Add(key, kMissed); });
    marks.Add(end.key, end.hit ? kHit : kMissed);
  }
  tree_->Update(marks);
}

void VoxelSpace::MarkOccupied(const std::vector<Eigen::Vector3d>& points_W) {
  for (const Eigen::Vector3d& p_WQ : points_W) {
    if (!p_WQ.allFinite()) {
      Throw<InvalidArgument>("voxel space: the point ({}, {}, {}) m is not finite", p_WQ.x(),
                             p_WQ.y(), p_WQ.z());
    }
    const Key key = tree_->KeyOf(p_WQ);
    if (InRange(key)) tree_->setNodeValue(Tree::ToOctomap(key), tree_->getClampingThresMaxLog());
  }
}

void VoxelSpace::ClearBox(const Eigen::AlignedBox3d& box_W) {
  CheckBox(box_W, "the box to clear");
  const auto [first, last] = KeyRange(tree_->InVoxels(box_W.min()), tree_->InVoxels(box_W.max()));
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        tree_->setNodeValue(Tree::ToOctomap({x, y, z}), tree_->getClampingThresMinLog());
      }
    }
  }
}

void VoxelSpace::RemoveRegion(const Eigen::AlignedBox3d& box_W) {
  CheckBox(box_W, "the region to remove");
  const auto [first, last] = KeyRange(tree_->InVoxels(box_W.min()), tree_->InVoxels(box_W.max()));
  tree_->Forget(first, last);
}

Occupancy VoxelSpace::At(const Eigen::Vector3d& p_WQ) const {
  const Key key = tree_->KeyOf(p_WQ);
  if (!InRange(key)) return Occupancy::kUnknown;
  const octomap::OcTreeNode* node = tree_->Find(key).node;
  if (node == nullptr) return Occupancy::kUnknown;
  return tree_->isNodeOccupied(node) ? Occupancy::kOccupied : Occupancy::kFree;
}

Passage VoxelSpace::Cast(const Eigen::Vector3d& p_WA, const Eigen::Vector3d& p_WB) const {
  Passage passage{false, p_WB, 0.0};
  const Eigen::Vector3d from = tree_->InVoxels(p_WA);
  const Eigen::Vector3d way = tree_->InVoxels(p_WB) - from;
  const double voxels = way.norm();
  const double nudge = 1e-6 / std::max(voxels, 1e-6);  // a millionth of a voxel past a face
  double t = 0.0;
  // From cube to cube: where neighbours agree, thousands of voxels are passed at once.
  while (t <= 1.0) {
    const Eigen::Vector3d at = from + (t + nudge) * way;
    if (!(at.minCoeff() >= 0.0 && at.maxCoeff() < 65536.0)) {
      passage.unknown += (1.0 - t) * voxels * config_.voxel_m;
      break;
    }
    const Key key = at.array().floor().cast<int>();
    const Tree::Cube cube = tree_->Find(key);
    if (cube.node != nullptr && tree_->isNodeOccupied(cube.node)) {
      passage.blocked = true;
      passage.p_WE = p_WA + t * (p_WB - p_WA);
      break;
    }
    double exit = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (way[axis] == 0.0) continue;
      const int low = (key[axis] >> cube.level) << cube.level;
      const double face = way[axis] > 0.0 ? low + (1 << cube.level) : low;
      exit = std::min(exit, (face - from[axis]) / way[axis]);
    }
    exit = std::clamp(exit, t + nudge, std::max(1.0, t + nudge));
    if (cube.node == nullptr) {
      passage.unknown += (std::min(exit, 1.0) - t) * voxels * config_.voxel_m;
    }
    if (exit >= 1.0) break;
    t = exit;
  }
  return passage;
}

double VoxelSpace::LikelyFreeShare(const std::vector<Eigen::Vector3d>& points_W) const {
  if (points_W.empty()) return 0.0;
  int likely_free = 0;
  for (const Eigen::Vector3d& p_WQ : points_W) {
    const Key key = tree_->KeyOf(p_WQ);
    const octomap::OcTreeNode* node = InRange(key) ? tree_->Find(key).node : nullptr;
    if (node != nullptr && node->getOccupancy() < config_.likely_free_below) ++likely_free;
  }
  return static_cast<double>(likely_free) / static_cast<double>(points_W.size());
}

void VoxelSpace::Visit(const Eigen::AlignedBox3d& box_W,
                       const std::function<void(const Voxel&)>& visitor) const {
  CheckBox(box_W, "the box to visit");
  const double reach = (30000.0 - 1.0) * config_.voxel_m;
  const Eigen::Vector3d low = box_W.min().cwiseMax(-reach);
  const Eigen::Vector3d high = box_W.max().cwiseMin(reach);
  if ((low.array() > high.array()).any() || tree_->size() == 0) return;
  const octomap::OcTreeKey first = Tree::ToOctomap(tree_->KeyOf(low));
  const octomap::OcTreeKey last = Tree::ToOctomap(tree_->KeyOf(high));
  for (auto leaf = tree_->begin_leafs_bbx(first, last); leaf != tree_->end_leafs_bbx(); ++leaf) {
    visitor({{leaf.getX(), leaf.getY(), leaf.getZ()}, leaf.getSize(), leaf->getOccupancy()});
  }
}

std::vector<Voxel> VoxelSpace::Occupied(const Eigen::AlignedBox3d& box_W) const {
  std::vector<Voxel> occupied;
  Visit(box_W, [&](const Voxel& voxel) {
    if (voxel.probability >= 0.5) occupied.push_back(voxel);
  });
  return occupied;
}

void VoxelSpace::Save(const std::filesystem::path& file) const {
  std::ostringstream bytes;
  const bool written = IsBinary(file) ? tree_->writeBinaryConst(bytes) : tree_->write(bytes);
  if (!written) Throw<ConfigError>("{}: OctoMap could not write the map", file.string());
  WriteFile(file, bytes.str());
}

void VoxelSpace::Load(const std::filesystem::path& file) {
  const bool binary = IsBinary(file);
  const std::string content = ReadFile(file);
  const char* header = binary ? "# Octomap OcTree binary file" : "# Octomap OcTree file";
  if (content.rfind(header, 0) != 0) {
    Throw<ConfigError>("{}: no octree; it does not begin with '{}'", file.string(), header);
  }
  std::istringstream bytes(content);
  Tree read(config_.voxel_m);
  if (binary) {
    if (!read.readBinary(bytes)) Throw<ConfigError>("{}: the octree is damaged", file.string());
  } else {
    const std::unique_ptr<octomap::AbstractOcTree> any(octomap::AbstractOcTree::read(bytes));
    auto* tree = dynamic_cast<octomap::OcTree*>(any.get());
    if (tree == nullptr) Throw<ConfigError>("{}: the octree is damaged", file.string());
    read.setResolution(tree->getResolution());
    read.swapContent(*tree);
  }
  if (std::abs(read.getResolution() - config_.voxel_m) > 1e-6) {
    Throw<ConfigError>("{}: its voxels are {} m wide, those of the map {} m; set voxel_m to match",
                       file.string(), read.getResolution(), config_.voxel_m);
  }
  tree_->swapContent(read);
}

const octomap::OcTree& VoxelSpace::octree() const { return *tree_; }

}  // namespace secondlook::world
