#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

namespace secondlook::geometry {

/// What a triangle looks like. The colour of a point is base_color x vertex colour x texture.
struct Material {
  Eigen::Vector3f base_color{1.0F, 1.0F, 1.0F};  ///< RGB in [0, 1].
  float specular{};                              ///< Strength of the highlight in [0, 1].
  float shininess{};                             ///< Phong exponent; 0: none.
  cv::Mat texture;                               ///< CV_8UC3, RGB, row 0 is v = 1; empty: none.
};

/// A triangle mesh in its model frame M [m]. Triangles wind counter-clockwise seen from outside.
/// It need not be watertight and its origin may lie anywhere.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;         ///< p_MV [m].
  std::vector<Eigen::Vector3i> triangles;        ///< Indices into `vertices`.
  std::vector<Eigen::Vector2f> uv;               ///< Per vertex, or empty. v points up.
  std::vector<Eigen::Vector3f> vertex_colors;    ///< Per vertex RGB in [0, 1], or empty.
  std::vector<std::uint16_t> triangle_material;  ///< Per triangle, index into `materials`.
  std::vector<Material> materials;               ///< At least one.

  bool empty() const { return triangles.empty(); }
};

/// The length unit a mesh file is written in.
enum class LengthUnit { kMetre, kMillimetre };

/// Parses "m" or "mm". @throws InvalidArgument naming `text` otherwise.
LengthUnit ParseLengthUnit(const std::string& text);

/// Reads a mesh (OBJ, PLY, GLB, glTF, STL, with textures and vertex colours) and scales it to
/// metres. Polygons are cut to triangles, triangles of no area dropped.
/// @throws ConfigError naming the file when it is missing, is no mesh, has no triangle, a vertex
/// that is not finite, a texture that cannot be read, or a size that shows a wrong unit: a diameter
/// over 3 m or under 5 mm is refused with the size in the declared unit and the advice to declare
/// the other.
Mesh LoadMesh(const std::filesystem::path& file, LengthUnit unit);

/// Writes `mesh` [m] as `folder`/mesh.obj, mesh.mtl and texture_<i>.png.
/// @throws ConfigError when that cannot be written.
void SaveObj(const Mesh& mesh, const std::filesystem::path& folder);

/// The box around the vertices, in M [m]. @pre !mesh.empty().
Eigen::AlignedBox3d Bounds(const Mesh& mesh);

/// The length of the diagonal of Bounds(mesh) [m], which the recognition literature calls the
/// model's diameter. @pre !mesh.empty().
double Diameter(const Mesh& mesh);

/// The colour, RGB in [0, 1], at barycentric `weights` of triangle `index`.
Eigen::Vector3f ColorAt(const Mesh& mesh, int index, const Eigen::Vector3f& weights);

/// An axis-aligned box of `size` [m] centred at the origin of M, 12 triangles, one colour.
Mesh MakeBox(const Eigen::Vector3d& size, const Eigen::Vector3f& color);

/// A cylinder about the z axis of M from z = 0 to `height` [m], closed, one colour.
/// @pre radius > 0, height > 0, segments >= 3.
Mesh MakeCylinder(double radius, double height, int segments, const Eigen::Vector3f& color);

/// A sphere about the origin of M, `rings` >= 3 from pole to pole, one colour.
Mesh MakeSphere(double radius, int rings, const Eigen::Vector3f& color);

}  // namespace secondlook::geometry
