#include "lib/world/solid_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lib/common/error.h"

namespace secondlook::world {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr int kMaxWidth = 512;

/// Calls `visit` for points of the triangle that lie no more than `spacing` apart.
template <class Visit>
void VisitPoints(const std::array<Vector3d, 3>& corners, double spacing, Visit visit) {
  const Vector3d a = corners[1] - corners[0];
  const Vector3d b = corners[2] - corners[0];
  const double longest = std::max({a.norm(), b.norm(), (a - b).norm()});
  const int steps = std::max(1, static_cast<int>(std::ceil(longest / spacing)));
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps - i; ++j) visit(corners[0] + (i * a + j * b) / steps);
  }
}

/// A box of voxels with a ring of empty ones around.
class Room {
 public:
  Room(const VoxelKey& low, const VoxelKey& high)
      : first_(low.array() - 1), size_((high - low).array() + 3) {
    surface_.assign(static_cast<std::size_t>(size_.prod()), 0);
  }

  void AddSurface(const VoxelKey& key) { surface_[Index(key - first_)] = 1; }

  /// All voxels that cannot be reached from the ring.
  std::vector<VoxelKey> Solid() const {
    std::vector<char> outside(surface_.size(), 0);
    std::vector<Vector3i> stack{Vector3i::Zero()};
    outside[0] = 1;
    while (!stack.empty()) {
      const Vector3i at = stack.back();
      stack.pop_back();
      for (int side = 0; side < 6; ++side) {
        Vector3i next = at;
        next[side / 2] += side % 2 == 0 ? 1 : -1;
        if (next.minCoeff() < 0 || (next.array() >= size_.array()).any()) continue;
        const std::size_t i = Index(next);
        if (outside[i] != 0 || surface_[i] != 0) continue;
        outside[i] = 1;
        stack.push_back(next);
      }
    }
    std::vector<VoxelKey> solid;
    for (int z = 0; z < size_.z(); ++z) {
      for (int y = 0; y < size_.y(); ++y) {
        for (int x = 0; x < size_.x(); ++x) {
          if (outside[Index({x, y, z})] == 0) solid.emplace_back(first_ + Vector3i(x, y, z));
        }
      }
    }
    return solid;
  }

 private:
  std::size_t Index(const Vector3i& at) const {
    return (static_cast<std::size_t>(at.z()) * size_.y() + at.y()) * size_.x() + at.x();
  }

  VoxelKey first_;
  Vector3i size_;
  std::vector<char> surface_;
};

}  // namespace

std::vector<VoxelKey> SolidVoxels(const geometry::Mesh& mesh, const Pose& X_WM, double voxel_m) {
  if (!IsValid(X_WM)) {
    Throw<InvalidArgument>("solid voxels: the pose X_WM is not finite and rigid");
  }
  const auto key_of = [&](const Vector3d& p_W) -> VoxelKey {
    return (p_W / voxel_m).array().floor().cast<int>();
  };
  Eigen::AlignedBox3d box_W;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box_W.extend(X_WM * vertex.cast<double>());
  if (mesh.empty() || !(box_W.sizes().maxCoeff() < kMaxWidth * voxel_m)) {
    Throw<InvalidArgument>(
        "solid voxels: a model of {} triangles, {} m wide, in voxels of {} m; it must have a "
        "triangle and be less than {} voxels wide",
        mesh.triangles.size(), mesh.empty() ? 0.0 : box_W.sizes().maxCoeff(), voxel_m, kMaxWidth);
  }
  Room room(key_of(box_W.min()), key_of(box_W.max()));
  for (const Vector3i& triangle : mesh.triangles) {
    std::array<Vector3d, 3> corners_W;
    for (int i = 0; i < 3; ++i) {
      corners_W[i] = X_WM * mesh.vertices[triangle[i]].cast<double>();
    }
    VisitPoints(corners_W, 0.5 * voxel_m,
                [&](const Vector3d& p_W) { room.AddSurface(key_of(p_W)); });
  }
  return room.Solid();
}

}  // namespace secondlook::world
