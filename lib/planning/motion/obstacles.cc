#include "lib/planning/motion/obstacles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "lib/common/check_range.h"
#include "lib/common/error.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using world::Brick;
using world::BrickGrid;
using world::BrickMask;

constexpr double kFloorThickness = 0.2;  // [m]
constexpr double kWallThickness = 3.0;   // [m]

bool IsFull(const BrickMask& mask) {
  return std::all_of(mask.begin(), mask.end(), [](std::uint64_t word) { return ~word == 0; });
}

BrickMask FullMask() {
  BrickMask mask;
  mask.fill(~std::uint64_t{0});
  return mask;
}

/// Collects the boxes of one grid.
class BoxCollector {
 public:
  BoxCollector(const BrickGrid& grid, std::vector<Obstacle>* obstacles)
      : voxel_(grid.voxel()), obstacles_(*obstacles) {}

  /// The voxels of `mask` in the brick whose lowest voxel is `first`.
  void Add(ObstacleKind kind, const Vector3i& first, BrickMask mask) {
    if (IsFull(mask)) {
      AddBox(kind, first, Vector3i::Constant(Brick::kEdge));
      return;
    }
    for (int z = 0; z < Brick::kEdge; ++z) AddLayer(kind, first + Vector3i(0, 0, z), mask[z]);
  }

 private:
  /// Rows of 8 bits: runs along x, and equal runs of rows that follow each other as one box.
  void AddLayer(ObstacleKind kind, const Vector3i& first, std::uint64_t bits) {
    while (bits != 0) {
      const int begin = __builtin_ctzll(bits);
      const int y = begin / Brick::kEdge;
      const int x = begin % Brick::kEdge;
      int width = 1;
      while (x + width < Brick::kEdge && (bits >> (begin + width) & 1) != 0) ++width;
      const std::uint64_t run = ((std::uint64_t{1} << width) - 1) << x;
      int rows = 1;
      while (y + rows < Brick::kEdge && (bits >> (Brick::kEdge * (y + rows)) & run) == run) {
        ++rows;
      }
      for (int i = 0; i < rows; ++i) bits &= ~(run << (Brick::kEdge * (y + i)));
      AddBox(kind, first + Vector3i(x, y, 0), {width, rows, 1});
    }
  }

  void AddBox(ObstacleKind kind, const Vector3i& first, const Vector3i& count) {
    Obstacle obstacle{kind, {geometry::Box{count.cast<double>() * voxel_}, Pose::Identity()}};
    obstacle.solid.X_AS.translation() =
        (first.cast<double>() + 0.5 * count.cast<double>()) * voxel_;
    obstacles_.push_back(obstacle);
  }

  double voxel_;
  std::vector<Obstacle>& obstacles_;
};

/// Tells which places are near to the robot's own body.
class OwnSpace {
 public:
  OwnSpace(const std::vector<geometry::PlacedShape>& body_W, double margin) : margin_(margin) {
    for (const geometry::PlacedShape& part : body_W) {
      parts_.push_back({part.shape, part.X_AS.inverse(), part.X_AS.translation(),
                        geometry::BoundingRadius(part.shape)});
    }
  }

  /// The parts that may reach into a ball.
  bool MayReach(const Vector3d& center_W, double radius) const {
    return std::any_of(parts_.begin(), parts_.end(), [&](const Part& part) {
      return (part.p_WS - center_W).norm() <= part.radius + margin_ + radius;
    });
  }

  bool Contains(const Vector3d& p_WQ) const {
    return std::any_of(parts_.begin(), parts_.end(), [&](const Part& part) {
      return (part.p_WS - p_WQ).norm() <= part.radius + margin_ &&
             geometry::Distance(part.shape, part.X_SW * p_WQ) <= margin_;
    });
  }

 private:
  struct Part {
    geometry::Shape shape;
    Pose X_SW;
    Vector3d p_WS;
    double radius;
  };
  std::vector<Part> parts_;
  double margin_;
};

/// The voxels of a brick whose centres fulfil `test`.
template <class Test>
BrickMask MaskOf(const BrickGrid& grid, const Vector3i& first, Test test) {
  BrickMask mask{};
  for (int i = 0; i < Brick::kVoxels; ++i) {
    const Vector3i key = first + Vector3i(i & 7, i >> 3 & 7, i >> 6);
    if (test(grid.CenterOf(key))) mask[i >> 6] |= std::uint64_t{1} << (i & 63);
  }
  return mask;
}

/// The blocked voxels of one brick.
struct Blocked {
  BrickMask occupied{};
  BrickMask unknown{FullMask()};

  explicit Blocked(const Brick* brick) {
    for (int i = 0; brick != nullptr && i < Brick::kEdge; ++i) {
      occupied[i] = brick->Occupied(i);
      unknown[i] = brick->Unknown(i);
    }
  }
};

void Remove(const BrickMask& gone, BrickMask* mask) {
  for (int i = 0; i < Brick::kEdge; ++i) (*mask)[i] &= ~gone[i];
}

/// What of a map is in the way within a ball.
class MapReader {
 public:
  MapReader(const Vector3d& p_WR, double reach, const OwnSpace& own, bool avoid_unknown)
      : p_WR_(p_WR), reach_(reach), own_(own), avoid_unknown_(avoid_unknown) {}

  /// Where the workspace answers, it alone does; where no grid reaches, all is unknown.
  void Read(const world::VoxelSpace& space, std::vector<Obstacle>* obstacles) const {
    Eigen::AlignedBox3d box_W(p_WR_.array() - reach_, p_WR_.array() + reach_);
    box_W.min().z() = std::max(box_W.min().z(), 0.0);  // the floor is below
    const BrickGrid& surroundings = space.surroundings();
    const BrickGrid* workspace = space.workspace();
    VisitLattice(surroundings, box_W, [&](const Vector3i& brick, const Eigen::AlignedBox3d& in_W) {
      const bool known = surroundings.Contains(in_W.center());
      Blocked blocked(known ? surroundings.Find(surroundings.DirectoryIndex(brick)) : nullptr);
      const Vector3i first = brick * Brick::kEdge;
      if (workspace != nullptr && workspace->box_W().intersects(in_W)) {
        const BrickMask answered = MaskOf(
            surroundings, first, [&](const Vector3d& p_W) { return workspace->Contains(p_W); });
        Remove(answered, &blocked.occupied);
        Remove(answered, &blocked.unknown);
      }
      Add(surroundings, first, in_W, blocked, obstacles);
    });
    if (workspace == nullptr) return;
    VisitLattice(*workspace, box_W.intersection(workspace->box_W()),
                 [&](const Vector3i& brick, const Eigen::AlignedBox3d& in_W) {
                   if (!workspace->Contains(in_W.center())) return;
                   Add(*workspace, brick * Brick::kEdge, in_W,
                       Blocked(workspace->Find(workspace->DirectoryIndex(brick))), obstacles);
                 });
  }

 private:
  /// Calls `visit` for every brick of the grid's lattice that reaches into `box_W` and the ball.
  template <class Visit>
  void VisitLattice(const BrickGrid& grid, const Eigen::AlignedBox3d& box_W, Visit visit) const {
    if (box_W.isEmpty()) return;
    const double edge = Brick::kEdge * grid.voxel();
    const Vector3i low = (box_W.min() / edge).array().floor().cast<int>();
    const Vector3i high = (box_W.max() / edge).array().ceil().cast<int>() - 1;
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const Vector3d corner_W = Vector3d(x, y, z) * edge;
          const Eigen::AlignedBox3d in_W(corner_W, corner_W.array() + edge);
          if (in_W.exteriorDistance(p_WR_) <= reach_) visit(Vector3i(x, y, z), in_W);
        }
      }
    }
  }

  void Add(const BrickGrid& grid, const Vector3i& first, const Eigen::AlignedBox3d& in_W,
           Blocked blocked, std::vector<Obstacle>* obstacles) const {
    BoxCollector collector(grid, obstacles);
    collector.Add(ObstacleKind::kOccupied, first, blocked.occupied);
    if (!avoid_unknown_) return;
    if (own_.MayReach(in_W.center(), 0.5 * in_W.diagonal().norm())) {
      Remove(MaskOf(grid, first, [&](const Vector3d& p_W) { return own_.Contains(p_W); }),
             &blocked.unknown);
    }
    collector.Add(ObstacleKind::kUnknown, first, blocked.unknown);
  }

  Vector3d p_WR_;
  double reach_;
  const OwnSpace& own_;
  bool avoid_unknown_;
};

}  // namespace

std::string ToString(ObstacleKind kind) {
  switch (kind) {
    case ObstacleKind::kOccupied:
      return "occupied space";
    case ObstacleKind::kUnknown:
      return "unknown space";
    case ObstacleKind::kSupport:
      return "a support surface";
    case ObstacleKind::kFloor:
      return "the floor";
    case ObstacleKind::kWorkspaceEdge:
      return "the edge of safety.limits.arm_workspace";
  }
  return "";
}

void ObstacleConfig::Validate() const {
  CheckRange(own_space_m, 0.0, 1.0, "own_space_m");
  CheckRange(support_margin_m, 0.0, 1.0, "support_margin_m");
}

std::vector<Obstacle> ObstaclesAround(const Vector3d& p_WR, double reach,
                                      const world::VoxelSpace& space,
                                      const std::vector<world::SupportPlane>& supports_W,
                                      const std::vector<geometry::PlacedShape>& own_body_W,
                                      const ObstacleConfig& config) {
  config.Validate();
  if (!p_WR.allFinite() || !(reach > 0.0 && reach <= 10.0)) {
    Throw<InvalidArgument>("obstacles: a reach of {} m around ({}, {}, {}) m", reach, p_WR.x(),
                           p_WR.y(), p_WR.z());
  }
  std::vector<Obstacle> obstacles;
  const OwnSpace own(own_body_W, config.own_space_m);
  MapReader(p_WR, reach, own, config.avoid_unknown).Read(space, &obstacles);
  for (const world::SupportPlane& support_W : supports_W) {
    obstacles.push_back(
        {ObstacleKind::kSupport, world::SolidBelow(support_W, config.support_margin_m)});
  }
  Obstacle floor{ObstacleKind::kFloor,
                 {geometry::Box{{2.0 * reach, 2.0 * reach, kFloorThickness}}, Pose::Identity()}};
  floor.solid.X_AS.translation() << p_WR.x(), p_WR.y(), -0.5 * kFloorThickness;
  obstacles.push_back(floor);
  return obstacles;
}

std::vector<Obstacle> WallsAround(const Eigen::AlignedBox3d& box_A, const Pose& X_WA) {
  const Vector3d middle_A = box_A.center();
  const Vector3d inner = box_A.sizes();
  std::vector<Obstacle> walls;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vector3d size = inner.array() + 2.0 * kWallThickness;
      size[axis] = kWallThickness;
      Vector3d p_AS = middle_A;
      p_AS[axis] += side * 0.5 * (inner[axis] + kWallThickness);
      walls.push_back({ObstacleKind::kWorkspaceEdge,
                       {geometry::Box{size}, X_WA * Pose(Eigen::Translation3d(p_AS))}});
    }
  }
  return walls;
}

}  // namespace secondlook::planning
