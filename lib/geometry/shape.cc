#include "lib/geometry/shape.h"

#include <algorithm>
#include <cmath>

namespace secondlook::geometry {
namespace {

double DistanceTo(const Box& box, const Eigen::Vector3d& p_SQ) {
  return (p_SQ.cwiseAbs() - 0.5 * box.size).cwiseMax(0.0).norm();
}

double DistanceTo(const Cylinder& cylinder, const Eigen::Vector3d& p_SQ) {
  return std::hypot(std::max(0.0, p_SQ.head<2>().norm() - cylinder.radius),
                    std::max(0.0, std::abs(p_SQ.z()) - 0.5 * cylinder.height));
}

double DistanceTo(const Sphere& sphere, const Eigen::Vector3d& p_SQ) {
  return std::max(0.0, p_SQ.norm() - sphere.radius);
}

double RadiusOf(const Box& box) { return 0.5 * box.size.norm(); }

double RadiusOf(const Cylinder& cylinder) {
  return std::hypot(cylinder.radius, 0.5 * cylinder.height);
}

double RadiusOf(const Sphere& sphere) { return sphere.radius; }

Mesh MeshOf(const Box& box, int /*segments*/, const Eigen::Vector3f& color) {
  return MakeBox(box.size, color);
}

Mesh MeshOf(const Cylinder& cylinder, int segments, const Eigen::Vector3f& color) {
  Mesh mesh = MakeCylinder(cylinder.radius, cylinder.height, segments, color);
  for (Eigen::Vector3f& p_MV : mesh.vertices) {
    p_MV.z() -= static_cast<float>(0.5 * cylinder.height);
  }
  return mesh;
}

Mesh MeshOf(const Sphere& sphere, int segments, const Eigen::Vector3f& color) {
  return MakeSphere(sphere.radius, segments / 2, color);
}

}  // namespace

double Distance(const Shape& shape, const Eigen::Vector3d& p_SQ) {
  return std::visit([&](const auto& solid) { return DistanceTo(solid, p_SQ); }, shape);
}

double BoundingRadius(const Shape& shape) {
  return std::visit([](const auto& solid) { return RadiusOf(solid); }, shape);
}

Mesh MakeMesh(const Shape& shape, int segments, const Eigen::Vector3f& color) {
  return std::visit([&](const auto& solid) { return MeshOf(solid, segments, color); }, shape);
}

}  // namespace secondlook::geometry
