#include "lib/world/octomap_exchange.h"

#include <bit>
#include <cmath>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>

#include <octomap/OcTree.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/world/bayes_update.h"

namespace secondlook::world {
namespace {

constexpr int kOctreeLevels = 16;
constexpr int kOctreeMiddle = 1 << (kOctreeLevels - 1);  ///< The key of the voxel above 0 in W.
constexpr double kMaxVoxels = 1 << 30;
constexpr std::string_view kBinaryHeader = "# Octomap OcTree binary file";
constexpr std::string_view kFullHeader = "# Octomap OcTree file";

octomap::OcTreeKey ToOctomap(const VoxelKey& key) {
  const Eigen::Vector3i shifted = key.array() + kOctreeMiddle;
  if (shifted.minCoeff() < 0 || shifted.maxCoeff() >= 2 * kOctreeMiddle) {
    Throw<InvalidArgument>(
        "octree: the voxel ({}, {}, {}) lies out of the {} voxels that OctoMap has on each side of "
        "the origin",
        key.x(), key.y(), key.z(), kOctreeMiddle);
  }
  return {static_cast<octomap::key_type>(shifted.x()), static_cast<octomap::key_type>(shifted.y()),
          static_cast<octomap::key_type>(shifted.z())};
}

/// Calls `visit(key, index in the brick)` for the voxels set in the mask.
template <class Visit>
void VisitVoxels(const Eigen::Vector3i& brick, int z, std::uint64_t mask, Visit visit) {
  for (; mask != 0; mask &= mask - 1) {
    const int bit = std::countr_zero(mask);
    visit(VoxelKey(Brick::kEdge * brick + Eigen::Vector3i(bit & 7, bit >> 3, z)), 64 * z + bit);
  }
}

bool IsBinary(const std::filesystem::path& file) {
  const std::string suffix = file.extension().string();
  if (suffix == ".bt") return true;
  if (suffix == ".ot") return false;
  Throw<ConfigError>("{}: a map ends in .bt or .ot, not in '{}'", file.string(), suffix);
}

/// Walks the nodes of a serialised octree without making them: OctoMap itself trusts what it reads.
class NodeWalk {
 public:
  NodeWalk(std::string_view nodes, bool binary) : nodes_(nodes), binary_(binary) {}

  /// The whole is one tree of at most 16 levels.
  bool IsTree() { return nodes_.empty() || (Node(0) && at_ == nodes_.size()); }

 private:
  bool Node(int level) {
    return level <= kOctreeLevels && (binary_ ? BinaryNode(level) : FullNode(level));
  }
  /// Two bits a child: 1, 2 a leaf, 3 a node of its own.
  bool BinaryNode(int level) {
    if (at_ + 2 > nodes_.size()) return false;
    const int children = Byte(0) | Byte(1) << 8;
    at_ += 2;
    for (int child = 0; child < 8; ++child) {
      if ((children >> (2 * child) & 3) == 3 && !Node(level + 1)) return false;
    }
    return true;
  }
  /// A float and a bit a child.
  bool FullNode(int level) {
    if (at_ + 5 > nodes_.size()) return false;
    const int children = Byte(4);
    at_ += 5;
    for (int child = 0; child < 8; ++child) {
      if ((children >> child & 1) != 0 && !Node(level + 1)) return false;
    }
    return true;
  }
  int Byte(std::size_t offset) const { return static_cast<unsigned char>(nodes_[at_ + offset]); }

  std::string_view nodes_;
  bool binary_;
  std::size_t at_{0};
};

/// @throws ConfigError naming the file when OctoMap could not read it safely.
void CheckContent(const std::filesystem::path& file, std::string_view content, bool binary) {
  const std::string_view header = binary ? kBinaryHeader : kFullHeader;
  if (content.substr(0, header.size()) != header) {
    Throw<ConfigError>("{}: no octree; it does not begin with '{}'", file.string(), header);
  }
  constexpr std::string_view kData = "\ndata\n";
  const std::size_t data = content.find(kData);
  if (data == std::string_view::npos ||
      !NodeWalk(content.substr(data + kData.size()), binary).IsTree()) {
    Throw<ConfigError>("{}: the octree is damaged", file.string());
  }
}

}  // namespace

octomap::OcTree ToOctree(const BrickGrid& grid) {
  octomap::OcTree tree(grid.voxel());
  const float standing = LogOdds(OccupancyModel{}.max_probability);
  grid.VisitBricks(grid.box_W(), [&](const Eigen::Vector3i& at, const Brick& brick) {
    for (int z = 0; z < Brick::kEdge; ++z) {
      VisitVoxels(at, z, ~brick.Unknown(z), [&](const VoxelKey& key, int index) {
        const bool stands = (brick.standing[z] >> (index & 63) & 1) != 0;
        tree.setNodeValue(ToOctomap(key), stands ? standing : brick.log_odds[index], true);
      });
    }
  });
  tree.updateInnerOccupancy();
  tree.prune();
  return tree;
}

octomap::OcTree OccupiedOctree(const BrickGrid& grid, const Eigen::AlignedBox3d& box_W) {
  octomap::OcTree tree(grid.voxel());
  const float occupied = tree.getClampingThresMaxLog();
  grid.VisitBricks(box_W, [&](const Eigen::Vector3i& at, const Brick& brick) {
    for (int z = 0; z < Brick::kEdge; ++z) {
      VisitVoxels(at, z, brick.Occupied(z), [&](const VoxelKey& key, int /*index*/) {
        tree.setNodeValue(ToOctomap(key), occupied, true);
      });
    }
  });
  tree.updateInnerOccupancy();
  return tree;
}

BrickGrid FromOctree(const octomap::OcTree& tree) {
  Eigen::AlignedBox3d box_W;
  double voxels = 0.0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const Eigen::Vector3d center(leaf.getX(), leaf.getY(), leaf.getZ());
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * leaf.getSize());
    box_W.extend(center - half).extend(center + half);
    voxels += std::pow(leaf.getSize() / tree.getResolution(), 3);
  }
  if (box_W.isEmpty()) Throw<InvalidArgument>("octree: it holds nothing");
  if (voxels > kMaxVoxels) {
    Throw<InvalidArgument>("octree: it holds {} voxels of {} m, more than {}", voxels,
                           tree.getResolution(), kMaxVoxels);
  }
  BrickGrid grid(tree.getResolution(), box_W);
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const Eigen::Vector3d center(leaf.getX(), leaf.getY(), leaf.getZ());
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * leaf.getSize());
    grid.Fill({center - half, center + half}, leaf->getLogOdds());
  }
  return grid;
}

void SaveMap(const BrickGrid& grid, const std::filesystem::path& file) {
  const bool binary = IsBinary(file);
  const octomap::OcTree tree = ToOctree(grid);
  std::ostringstream bytes;
  const bool written = binary ? tree.writeBinaryConst(bytes) : tree.write(bytes);
  if (!written) Throw<ConfigError>("{}: OctoMap could not write the map", file.string());
  WriteFile(file, bytes.str());
}

BrickGrid LoadMap(const std::filesystem::path& file, double voxel_m) try {
  const bool binary = IsBinary(file);
  const std::string content = ReadFile(file);
  CheckContent(file, content, binary);
  std::istringstream bytes(content);
  std::unique_ptr<octomap::OcTree> tree;
  if (binary) {
    tree = std::make_unique<octomap::OcTree>(voxel_m);
    if (!tree->readBinary(bytes)) tree.reset();
  } else {
    std::unique_ptr<octomap::AbstractOcTree> any(octomap::AbstractOcTree::read(bytes));
    if (auto* read = dynamic_cast<octomap::OcTree*>(any.get()); read != nullptr) {
      any.release();
      tree.reset(read);
    }
  }
  if (tree == nullptr) Throw<ConfigError>("{}: the octree is damaged", file.string());
  if (!(std::abs(tree->getResolution() - voxel_m) <= 1e-6)) {
    Throw<ConfigError>("{}: its voxels are {} m wide, those of the map {} m; set voxel_m to match",
                       file.string(), tree->getResolution(), voxel_m);
  }
  return FromOctree(*tree);
} catch (const InvalidArgument& error) {
  Throw<ConfigError>("{}: {}", file.string(), error.what());
}

}  // namespace secondlook::world
