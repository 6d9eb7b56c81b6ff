#include "lib/geometry/mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>
#include <unordered_map>

#include <assimp/GltfMaterial.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/geometry/ply_check.h"

namespace secondlook::geometry {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxDiameter = 3.0;    // [m] larger: the unit is wrong
constexpr double kMinDiameter = 0.005;  // [m] smaller: likewise
constexpr float kNoArea = 1e-14F;       // [m^2] twice the area of a triangle that is dropped

std::string LowerExtension(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

bool IsGltf(const fs::path& file) {
  const std::string extension = LowerExtension(file);
  return extension == ".glb" || extension == ".gltf";
}

void CheckExtension(const fs::path& file) {
  const std::string extension = LowerExtension(file);
  for (const char* known : {".obj", ".ply", ".glb", ".gltf", ".stl"}) {
    if (extension == known) return;
  }
  Throw<ConfigError>("{}: '{}' is not a mesh format; use .obj, .ply, .glb, .gltf or .stl",
                     file.string(), extension);
}

/// The name of a texture file as written, without the blanks around it and with forward slashes.
std::string CleanName(std::string name) {
  const auto blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!name.empty() && blank(name.back())) name.pop_back();
  while (!name.empty() && blank(name.front())) name.erase(name.begin());
  std::replace(name.begin(), name.end(), '\\', '/');
  return name;
}

/// The image in a compressed file, RGB; empty when it is none.
cv::Mat Decode(const void* bytes, std::size_t size) {
  if (size == 0) return {};
  const cv::Mat encoded(1, static_cast<int>(size), CV_8UC1, const_cast<void*>(bytes));
  const cv::Mat bgr = cv::imdecode(encoded, cv::IMREAD_COLOR);
  cv::Mat rgb;
  if (!bgr.empty()) cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

/// A texture that lies within the mesh file: compressed when its height is 0, else BGRA texels.
cv::Mat DecodeEmbedded(const aiTexture& texture) {
  if (texture.mHeight != 0) {
    const cv::Mat bgra(static_cast<int>(texture.mHeight), static_cast<int>(texture.mWidth), CV_8UC4,
                       texture.pcData);
    cv::Mat rgb;
    cv::cvtColor(bgra, rgb, cv::COLOR_BGRA2RGB);
    return rgb;
  }
  return Decode(texture.pcData, texture.mWidth);
}

cv::Mat ReadTexture(const fs::path& file, const aiScene& scene, const std::string& name) {
  if (const aiTexture* embedded = scene.GetEmbeddedTexture(name.c_str())) {
    cv::Mat texture = DecodeEmbedded(*embedded);
    if (texture.empty()) {
      Throw<ConfigError>("{}: its embedded texture '{}' cannot be decoded", file.string(), name);
    }
    return texture;
  }
  const fs::path path = file.parent_path() / CleanName(name);
  cv::Mat texture;
  if (fs::is_regular_file(path)) {
    const std::string bytes = ReadFile(path);
    texture = Decode(bytes.data(), bytes.size());
  }
  if (texture.empty()) {
    Throw<ConfigError>(
        "{}: its texture '{}' cannot be read; put the image there or correct the "
        "material",
        file.string(), path.string());
  }
  return texture;
}

Eigen::Vector3f ToVector(const aiColor4D& color) { return {color.r, color.g, color.b}; }

Material ReadMaterial(const fs::path& file, const aiScene& scene, const aiMaterial& source) {
  Material material;
  aiString name;
  source.Get(AI_MATKEY_NAME, name);
  const bool is_default = std::string(name.C_Str()) == AI_DEFAULT_MATERIAL_NAME;
  aiColor4D color;
  const bool has_color = source.Get(AI_MATKEY_BASE_COLOR, color) == AI_SUCCESS ||
                         source.Get(AI_MATKEY_COLOR_DIFFUSE, color) == AI_SUCCESS;
  if (has_color && !is_default) material.base_color = ToVector(color);
  aiString texture;
  if (source.GetTexture(aiTextureType_BASE_COLOR, 0, &texture) == AI_SUCCESS ||
      source.GetTexture(aiTextureType_DIFFUSE, 0, &texture) == AI_SUCCESS) {
    material.texture = ReadTexture(file, scene, texture.C_Str());
    // Outside glTF the texture is the colour; the Kd beside it is often left at a default.
    if (!IsGltf(file)) material.base_color.setOnes();
  }
  aiColor4D specular;
  float shininess = 0.0F;
  if (source.Get(AI_MATKEY_COLOR_SPECULAR, specular) == AI_SUCCESS &&
      source.Get(AI_MATKEY_SHININESS, shininess) == AI_SUCCESS && shininess > 0.0F) {
    material.specular = std::clamp(ToVector(specular).mean(), 0.0F, 1.0F);
    material.shininess = shininess;
  }
  return material;
}

/// What makes two corners of triangles one vertex: equal position, texture coordinate and colour.
using VertexKey = std::array<float, 8>;

struct VertexKeyHash {
  std::size_t operator()(const VertexKey& key) const {
    std::uint64_t hash = 0;
    for (const float value : key) {
      hash = (hash ^ std::bit_cast<std::uint32_t>(value)) * 0x9e3779b97f4a7c15ULL;
      hash ^= hash >> 29;
    }
    return hash;
  }
};

/// Gathers the parts of an assimp scene in one mesh, equal vertices joined.
class MeshBuilder {
 public:
  MeshBuilder(const fs::path& file, const aiScene& scene, float scale)
      : file_(file), scene_(scene), scale_(scale) {
    for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
      has_uv_ = has_uv_ || scene.mMeshes[i]->HasTextureCoords(0);
      has_colors_ = has_colors_ || scene.mMeshes[i]->HasVertexColors(0);
    }
  }

  Mesh Build() {
    AddNode(*scene_.mRootNode, aiMatrix4x4());
    return std::move(mesh_);
  }

 private:
  void AddNode(const aiNode& node, const aiMatrix4x4& parent) {
    const aiMatrix4x4 transform = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      AddPart(*scene_.mMeshes[node.mMeshes[i]], transform);
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) AddNode(*node.mChildren[i], transform);
  }

  void AddPart(const aiMesh& part, const aiMatrix4x4& transform) {
    std::vector<int> indices(part.mNumVertices);
    for (unsigned i = 0; i < part.mNumVertices; ++i) indices[i] = AddVertex(part, i, transform);
    const bool mirrored = transform.Determinant() < 0.0F;
    const std::uint16_t material = MaterialIndex(part.mMaterialIndex);
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;  // a line or a point
      CheckIndices(face, part.mNumVertices);
      Eigen::Vector3i triangle(indices[face.mIndices[0]], indices[face.mIndices[1]],
                               indices[face.mIndices[2]]);
      if (mirrored) std::swap(triangle[1], triangle[2]);
      AddTriangle(triangle, material);
    }
  }

  void CheckIndices(const aiFace& face, unsigned vertices) const {
    for (unsigned i = 0; i < 3; ++i) {
      if (face.mIndices[i] < vertices) continue;
      Throw<ConfigError>("{}: a triangle names vertex {} of {}", file_.string(), face.mIndices[i],
                         vertices);
    }
  }

  int AddVertex(const aiMesh& part, unsigned i, const aiMatrix4x4& transform) {
    const aiVector3D p = transform * part.mVertices[i] * scale_;
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      Throw<ConfigError>("{}: vertex {} of {} is not finite", file_.string(), i, part.mNumVertices);
    }
    const aiVector3D uv = part.HasTextureCoords(0) ? part.mTextureCoords[0][i] : aiVector3D();
    const aiColor4D color = part.HasVertexColors(0) ? part.mColors[0][i] : aiColor4D(1, 1, 1, 1);
    const VertexKey key{p.x, p.y, p.z, uv.x, uv.y, color.r, color.g, color.b};
    const auto [entry, is_new] = joined_.try_emplace(key, static_cast<int>(mesh_.vertices.size()));
    if (is_new) {
      mesh_.vertices.emplace_back(p.x, p.y, p.z);
      if (has_uv_) mesh_.uv.emplace_back(uv.x, uv.y);
      if (has_colors_) mesh_.vertex_colors.emplace_back(color.r, color.g, color.b);
    }
    return entry->second;
  }

  void AddTriangle(const Eigen::Vector3i& triangle, std::uint16_t material) {
    const Eigen::Vector3f& a = mesh_.vertices[triangle[0]];
    const Eigen::Vector3f& b = mesh_.vertices[triangle[1]];
    const Eigen::Vector3f& c = mesh_.vertices[triangle[2]];
    if (!((b - a).cross(c - a).norm() > kNoArea)) return;
    mesh_.triangles.push_back(triangle);
    mesh_.triangle_material.push_back(material);
  }

  /// Only the materials in use are read, each once: files list others whose textures are missing.
  std::uint16_t MaterialIndex(unsigned source) {
    const auto [entry, is_new] =
        materials_.try_emplace(source, static_cast<std::uint16_t>(mesh_.materials.size()));
    if (is_new) mesh_.materials.push_back(ReadMaterial(file_, scene_, *scene_.mMaterials[source]));
    return entry->second;
  }

  const fs::path& file_;
  const aiScene& scene_;
  float scale_;
  bool has_uv_{};
  bool has_colors_{};
  Mesh mesh_;
  std::unordered_map<VertexKey, int, VertexKeyHash> joined_;
  std::map<unsigned, std::uint16_t> materials_;
};

void CheckSize(const fs::path& file, const Mesh& mesh, LengthUnit unit) {
  const double diameter = Diameter(mesh);
  if (diameter >= kMinDiameter && diameter <= kMaxDiameter) return;
  const bool metres = unit == LengthUnit::kMetre;
  Throw<ConfigError>(
      "{}: it measures {:.4g} {} from corner to corner, and a model must lie between "
      "{} mm and {} m; is its unit '{}' rather than '{}'?",
      file.string(), metres ? diameter : diameter * 1e3, metres ? "m" : "mm", kMinDiameter * 1e3,
      kMaxDiameter, metres ? "mm" : "m", metres ? "m" : "mm");
}

Mesh SingleColor(const Eigen::Vector3f& color) {
  Mesh mesh;
  mesh.materials.push_back(
      {.base_color = color, .specular = 0.0F, .shininess = 0.0F, .texture = {}});
  return mesh;
}

void AddTriangle(Mesh* mesh, int a, int b, int c) {
  mesh->triangles.emplace_back(a, b, c);
  mesh->triangle_material.push_back(0);
}

/// Adds the points of a circle about z and returns the index of the first.
int AddCircle(Mesh* mesh, double radius, double z, int segments) {
  const int first = static_cast<int>(mesh->vertices.size());
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / segments;
    mesh->vertices.push_back(
        Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), z).cast<float>());
  }
  return first;
}

int AddVertex(Mesh* mesh, double z) {
  mesh->vertices.emplace_back(0.0F, 0.0F, static_cast<float>(z));
  return static_cast<int>(mesh->vertices.size()) - 1;
}

/// The texel at column x, row y, repeated beyond the borders.
Eigen::Vector3f Texel(const cv::Mat& texture, int x, int y) {
  const auto wrap = [](int i, int size) { return ((i % size) + size) % size; };
  const cv::Vec3b& rgb = texture.at<cv::Vec3b>(wrap(y, texture.rows), wrap(x, texture.cols));
  return Eigen::Vector3f(rgb[0], rgb[1], rgb[2]) / 255.0F;
}

Eigen::Vector3f SampleBilinear(const cv::Mat& texture, const Eigen::Vector2f& uv) {
  const float x = (uv.x() - std::floor(uv.x())) * static_cast<float>(texture.cols) - 0.5F;
  const float v = uv.y() - std::floor(uv.y());
  const float y = (1.0F - v) * static_cast<float>(texture.rows) - 0.5F;
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = static_cast<int>(std::floor(y));
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  return (1 - fy) * ((1 - fx) * Texel(texture, x0, y0) + fx * Texel(texture, x0 + 1, y0)) +
         fy * ((1 - fx) * Texel(texture, x0, y0 + 1) + fx * Texel(texture, x0 + 1, y0 + 1));
}

std::string ObjText(const Mesh& mesh) {
  std::string text = "mtllib mesh.mtl\n";
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f& p = mesh.vertices[i];
    text += fmt::format("v {} {} {}", p.x(), p.y(), p.z());
    if (!mesh.vertex_colors.empty()) {
      const Eigen::Vector3f& c = mesh.vertex_colors[i];
      text += fmt::format(" {} {} {}", c.x(), c.y(), c.z());
    }
    text += '\n';
  }
  for (const Eigen::Vector2f& uv : mesh.uv) text += fmt::format("vt {} {}\n", uv.x(), uv.y());
  int material = -1;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangle_material[i] != material) {
      material = mesh.triangle_material[i];
      text += fmt::format("usemtl material_{}\n", material);
    }
    const Eigen::Vector3i corners =
        mesh.triangles[i] + Eigen::Vector3i::Ones();  // OBJ counts from 1
    text += mesh.uv.empty()
                ? fmt::format("f {} {} {}\n", corners[0], corners[1], corners[2])
                : fmt::format("f {0}/{0} {1}/{1} {2}/{2}\n", corners[0], corners[1], corners[2]);
  }
  return text;
}

std::string MtlText(const Mesh& mesh) {
  std::string text;
  for (std::size_t i = 0; i < mesh.materials.size(); ++i) {
    const Material& m = mesh.materials[i];
    text += fmt::format("newmtl material_{}\nKd {} {} {}\nKs {} {} {}\nNs {}\n", i,
                        m.base_color.x(), m.base_color.y(), m.base_color.z(), m.specular,
                        m.specular, m.specular, m.shininess);
    if (!m.texture.empty()) text += fmt::format("map_Kd texture_{}.png\n", i);
  }
  return text;
}

/// An OBJ's texture is its colour, so the base colour goes into it.
cv::Mat TextureTimesBaseColor(const Material& material) {
  cv::Mat texture;
  const Eigen::Vector3f& c = material.base_color;
  cv::multiply(material.texture, cv::Scalar(c.x(), c.y(), c.z()), texture);
  cv::cvtColor(texture, texture, cv::COLOR_RGB2BGR);
  return texture;
}

/// Assimp triangulates without looking: a face that is none would end the process.
void CheckFaces(const fs::path& file, const aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices == 0) {
        Throw<ConfigError>("{}: face {} of mesh {} has no corners", file.string(), f, m);
      }
      for (unsigned i = 0; i < face.mNumIndices; ++i) {
        if (face.mIndices[i] < mesh.mNumVertices) continue;
        Throw<ConfigError>("{}: face {} of mesh {} has vertex {}, and there are {}", file.string(),
                           f, m, face.mIndices[i], mesh.mNumVertices);
      }
    }
  }
}

}  // namespace

LengthUnit ParseLengthUnit(const std::string& text) {
  if (text == "m") return LengthUnit::kMetre;
  if (text == "mm") return LengthUnit::kMillimetre;
  Throw<InvalidArgument>("'{}' is not a length unit; use m or mm", text);
}

Mesh LoadMesh(const fs::path& file, LengthUnit unit) {
  if (!fs::is_regular_file(file)) {
    Throw<ConfigError>("{}: there is no such mesh file", file.string());
  }
  CheckExtension(file);
  if (LowerExtension(file) == ".ply") CheckPlyIsWhole(file);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  if (scene != nullptr) {
    CheckFaces(file, *scene);
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  }
  if (scene == nullptr || scene->mRootNode == nullptr) {
    Throw<ConfigError>("{}: it is not a readable mesh: {}", file.string(),
                       importer.GetErrorString());
  }
  const float scale = unit == LengthUnit::kMetre ? 1.0F : 1e-3F;
  Mesh mesh = MeshBuilder(file, *scene, scale).Build();
  if (mesh.empty()) {
    Throw<ConfigError>("{}: it has no triangle; a point cloud is not a mesh", file.string());
  }
  CheckSize(file, mesh, unit);
  return mesh;
}

void SaveObj(const Mesh& mesh, const fs::path& folder) {
  WriteFile(folder / "mesh.obj", ObjText(mesh));
  WriteFile(folder / "mesh.mtl", MtlText(mesh));
  for (std::size_t i = 0; i < mesh.materials.size(); ++i) {
    if (mesh.materials[i].texture.empty()) continue;
    std::vector<unsigned char> png;
    cv::imencode(".png", TextureTimesBaseColor(mesh.materials[i]), png);
    WriteFile(folder / fmt::format("texture_{}.png", i),
              std::string_view(reinterpret_cast<const char*>(png.data()), png.size()));
  }
}

Eigen::AlignedBox3d Bounds(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : mesh.vertices) box.extend(p.cast<double>());
  return box;
}

double Diameter(const Mesh& mesh) { return Bounds(mesh).diagonal().norm(); }

Eigen::Vector3f ColorAt(const Mesh& mesh, int index, const Eigen::Vector3f& weights) {
  const Eigen::Vector3i& corners = mesh.triangles[index];
  const Material& material = mesh.materials[mesh.triangle_material[index]];
  Eigen::Vector3f color = material.base_color;
  if (!mesh.vertex_colors.empty()) {
    Eigen::Vector3f mixed = Eigen::Vector3f::Zero();
    for (int i = 0; i < 3; ++i) mixed += weights[i] * mesh.vertex_colors[corners[i]];
    color = color.cwiseProduct(mixed);
  }
  if (!material.texture.empty() && !mesh.uv.empty()) {
    Eigen::Vector2f uv = Eigen::Vector2f::Zero();
    for (int i = 0; i < 3; ++i) uv += weights[i] * mesh.uv[corners[i]];
    color = color.cwiseProduct(SampleBilinear(material.texture, uv));
  }
  return color;
}

Mesh MakeBox(const Eigen::Vector3d& size, const Eigen::Vector3f& color) {
  Mesh mesh = SingleColor(color);
  for (int i = 0; i < 8; ++i) {  // bit 0: x, bit 1: y, bit 2: z
    const Eigen::Vector3d corner((i & 1) - 0.5, ((i >> 1) & 1) - 0.5, ((i >> 2) & 1) - 0.5);
    mesh.vertices.push_back(corner.cwiseProduct(size).cast<float>());
  }
  constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : kFaces) {
    AddTriangle(&mesh, f[0], f[1], f[2]);
    AddTriangle(&mesh, f[0], f[2], f[3]);
  }
  return mesh;
}

Mesh MakeCylinder(double radius, double height, int segments, const Eigen::Vector3f& color) {
  Mesh mesh = SingleColor(color);
  const int lower = AddCircle(&mesh, radius, 0.0, segments);
  const int upper = AddCircle(&mesh, radius, height, segments);
  const int bottom = AddVertex(&mesh, 0.0);
  const int top = AddVertex(&mesh, height);
  for (int i = 0; i < segments; ++i) {
    const int j = (i + 1) % segments;
    AddTriangle(&mesh, lower + i, lower + j, upper + j);
    AddTriangle(&mesh, lower + i, upper + j, upper + i);
    AddTriangle(&mesh, bottom, lower + j, lower + i);
    AddTriangle(&mesh, top, upper + i, upper + j);
  }
  return mesh;
}

Mesh MakeSphere(double radius, int rings, const Eigen::Vector3f& color) {
  Mesh mesh = SingleColor(color);
  const int segments = 2 * rings;
  const int south = AddVertex(&mesh, -radius);
  int below = 0;
  for (int ring = 1; ring < rings; ++ring) {
    const double latitude = std::numbers::pi * (static_cast<double>(ring) / rings - 0.5);
    const int circle =
        AddCircle(&mesh, radius * std::cos(latitude), radius * std::sin(latitude), segments);
    for (int i = 0; i < segments; ++i) {
      const int j = (i + 1) % segments;
      if (ring == 1) {
        AddTriangle(&mesh, south, circle + j, circle + i);
      } else {
        AddTriangle(&mesh, below + i, below + j, circle + j);
        AddTriangle(&mesh, below + i, circle + j, circle + i);
      }
    }
    below = circle;
  }
  const int north = AddVertex(&mesh, radius);
  for (int i = 0; i < segments; ++i) {
    AddTriangle(&mesh, below + i, below + (i + 1) % segments, north);
  }
  return mesh;
}

}  // namespace secondlook::geometry
