#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "lib/geometry/mesh.h"

namespace secondlook::geometry {

/// A half line in M. With a direction whose component along a camera's optical axis is 1, as
/// CameraModel::Ray() gives it, distances along it are depths.
struct Ray {
  Eigen::Vector3f p_MO;         ///< Where it starts [m].
  Eigen::Vector3f direction_M;  ///< Of any length but zero.
};

/// Where a ray first meets a mesh.
struct RayHit {
  int triangle{-1};          ///< -1: it misses.
  float distance{};          ///< In lengths of the ray's direction.
  Eigen::Vector3f weights;   ///< Barycentric on the triangle, for ColorAt().
  Eigen::Vector3f normal_M;  ///< Unit, of the triangle, by its winding.
};

/// Casts rays at one mesh (Embree). Both faces of a triangle count. Making it costs about a
/// microsecond a triangle, so keep it with the model.
/// Threading: Cast() from any number of threads.
class RayCaster {
 public:
  /// Copies what it needs of `mesh`. @throws InvalidArgument when it has no triangle.
  explicit RayCaster(const Mesh& mesh);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// One hit a ray, in their order.
  std::vector<RayHit> Cast(std::span<const Ray> rays_M) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace secondlook::geometry
