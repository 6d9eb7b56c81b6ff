#pragma once

#include <cstdint>
#include <vector>

#include "lib/geometry/mesh.h"

namespace secondlook::sim {

/// A corner of a triangle as the graphics library takes it.
struct ShadedVertex {
  float position[3];  ///< p_MV [m].
  float normal[3];    ///< In M, unit.
  float uv[2];
  float color[3];  ///< Linear RGB.
};

/// The triangles of one material: `indices` [first, first + count).
struct MaterialRange {
  std::uint16_t material{};
  int first{};
  int count{};
};

/// A mesh with normals, its triangles sorted by material.
struct ShadedMesh {
  std::vector<ShadedVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<MaterialRange> ranges;
};

/// Gives each corner the area-weighted mean normal of the triangles around its point that differ
/// by less than `crease` [rad] from its own, so that round things look round and boxes keep their
/// edges; triangles meet at equal positions, whatever their texture coordinates.
ShadedMesh Shade(const geometry::Mesh& mesh, double crease);

/// An sRGB value in [0, 1] made linear (IEC 61966-2-1).
float LinearFromSrgb(float value);

}  // namespace secondlook::sim
