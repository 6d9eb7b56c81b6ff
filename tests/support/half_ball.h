#pragma once

#include "lib/world/support_plane.h"
#include "lib/world/surface_volume.h"

namespace secondlook::tests {

/// The level plane at `height` [m], large.
inline world::SupportPlane LevelPlane(double height) {
  world::SupportPlane plane;
  plane.offset = height;
  plane.corners_A = {Eigen::Vector3d(-1, -1, height), Eigen::Vector3d(1, -1, height),
                     Eigen::Vector3d(1, 1, height), Eigen::Vector3d(-1, 1, height)};
  return plane;
}

/// A ball about the origin, of which only what `keep(vertex)` says was measured.
template <class Keep>
world::PartialMesh PartOfBall(double radius, int rings, Keep keep) {
  world::PartialMesh part;
  part.mesh = geometry::MakeSphere(radius, rings, Eigen::Vector3f::Constant(0.5F));
  std::erase_if(part.mesh.triangles, [&](const Eigen::Vector3i& t) {
    return !keep(part.mesh.vertices[t[0]]) || !keep(part.mesh.vertices[t[1]]) ||
           !keep(part.mesh.vertices[t[2]]);
  });
  for (const Eigen::Vector3f& vertex : part.mesh.vertices) {
    part.normals.push_back(vertex.normalized());
  }
  part.density.assign(part.mesh.vertices.size(), 1.0F);
  return part;
}

}  // namespace secondlook::tests
