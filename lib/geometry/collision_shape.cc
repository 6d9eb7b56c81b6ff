#include "lib/geometry/collision_shape.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>

namespace secondlook::geometry {
namespace {

using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

Geometry Grown(const Box& box, double margin) {
  const Eigen::Vector3d size = box.size.array() + 2.0 * margin;
  return std::make_shared<fcl::Boxd>(size);
}

Geometry Grown(const Cylinder& cylinder, double margin) {
  return std::make_shared<fcl::Cylinderd>(cylinder.radius + margin, cylinder.height + 2.0 * margin);
}

Geometry Grown(const Sphere& sphere, double margin) {
  return std::make_shared<fcl::Sphered>(sphere.radius + margin);
}

}  // namespace

Geometry MakeCollisionShape(const Shape& shape, double margin) {
  Geometry grown = std::visit([&](const auto& solid) { return Grown(solid, margin); }, shape);
  grown->computeLocalAABB();
  return grown;
}

Geometry MakeCollisionSurface(const Mesh& mesh) {
  auto surface = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
  surface->beginModel(static_cast<int>(mesh.triangles.size()),
                      static_cast<int>(mesh.vertices.size()));
  std::vector<fcl::Vector3d> vertices;
  for (const Eigen::Vector3f& p_MV : mesh.vertices) vertices.push_back(p_MV.cast<double>());
  std::vector<fcl::Triangle> triangles;
  for (const auto& t : mesh.triangles) {
    triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                           static_cast<std::size_t>(t[2]));
  }
  surface->addSubModel(vertices, triangles);
  surface->endModel();
  surface->computeLocalAABB();
  return surface;
}

}  // namespace secondlook::geometry
