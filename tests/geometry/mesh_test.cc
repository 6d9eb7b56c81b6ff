#include "lib/geometry/mesh.h"

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "tests/support/expect_throws.h"

namespace secondlook::geometry {
namespace {

namespace fs = std::filesystem;
constexpr LengthUnit kMetre = LengthUnit::kMetre;

/// A folder of its own for each test, removed afterwards.
class MeshFile : public ::testing::Test {
 protected:
  MeshFile()
      : folder_(fs::path(::testing::TempDir()) /
                (std::string("mesh_") +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~MeshFile() override { fs::remove_all(folder_); }

  fs::path Write(const std::string& name, const std::string& text) const {
    WriteFile(folder_ / name, text);
    return folder_ / name;
  }

  fs::path folder_;
};

/// The volume enclosed by a closed mesh, by the divergence theorem: positive when triangles wind
/// counter-clockwise seen from outside.
double SignedVolume(const Mesh& mesh) {
  double sum = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
    sum += a.dot(mesh.vertices[t[1]].cast<double>().cross(mesh.vertices[t[2]].cast<double>()));
  }
  return sum / 6.0;
}

constexpr const char* kTriangle = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n";

TEST(Mesh, ABoxHasItsVolumeAndWindsOutwards) {
  const Mesh box = MakeBox({0.2, 0.3, 0.4}, {1, 0, 0});
  EXPECT_EQ(box.triangles.size(), 12U);
  EXPECT_NEAR(SignedVolume(box), 0.024, 1e-8);
  EXPECT_TRUE(Bounds(box).min().isApprox(Eigen::Vector3d(-0.1, -0.15, -0.2), 1e-6));
  EXPECT_NEAR(Diameter(box), std::sqrt(0.29), 1e-6);
}

TEST(Mesh, ACylinderHasTheVolumeOfThePrismAndStandsOnZero) {
  const int n = 40;
  const Mesh cylinder = MakeCylinder(0.1, 0.5, n, {1, 1, 1});
  const double prism = 0.5 * n * 0.01 * std::sin(2 * std::numbers::pi / n) * 0.5;
  EXPECT_NEAR(SignedVolume(cylinder), prism, 1e-7);
  EXPECT_EQ(Bounds(cylinder).min().z(), 0.0);
  EXPECT_NEAR(Bounds(cylinder).max().z(), 0.5, 1e-7);
}

TEST(Mesh, ASphereIsClosedAndItsVerticesLieOnIt) {
  const Mesh sphere = MakeSphere(0.1, 64, {1, 1, 1});
  for (const Eigen::Vector3f& p : sphere.vertices) EXPECT_NEAR(p.norm(), 0.1F, 1e-7F);
  EXPECT_NEAR(SignedVolume(sphere), 4.0 / 3.0 * std::numbers::pi * 1e-3, 1e-5);
}

TEST(Mesh, ParsesTheUnitsOfLength) {
  EXPECT_EQ(ParseLengthUnit("m"), LengthUnit::kMetre);
  EXPECT_EQ(ParseLengthUnit("mm"), LengthUnit::kMillimetre);
  EXPECT_THROWS(ParseLengthUnit("cm"), InvalidArgument, "'cm' is not a length unit; use m or mm");
}

TEST_F(MeshFile, CutsPolygonsAndJoinsEqualCorners) {
  const Mesh mesh = LoadMesh(Write("square.obj",
                                   "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nf 1 2 3 4\n"
                                   "f 1 1 2\n"),
                             kMetre);
  EXPECT_EQ(mesh.triangles.size(), 2U);  // the triangle without area is gone
  EXPECT_EQ(mesh.vertices.size(), 4U);
  EXPECT_EQ(mesh.materials.size(), 1U);
  EXPECT_EQ(mesh.triangle_material.size(), 2U);
}

TEST_F(MeshFile, ScalesMillimetresToMetres) {
  const fs::path file = Write("part.obj", "v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n");
  EXPECT_NEAR(Diameter(LoadMesh(file, LengthUnit::kMillimetre)), std::sqrt(0.02), 1e-6);
  EXPECT_THROWS(LoadMesh(file, kMetre), ConfigError,
                "part.obj: it measures 141.4 m from corner to corner, and a model must lie between "
                "5 mm and 3 m; is its unit 'mm' rather than 'm'?");
  EXPECT_THROWS(LoadMesh(Write("tiny.obj", kTriangle), LengthUnit::kMillimetre), ConfigError,
                "tiny.obj: it measures 0.1414 mm from corner to corner");
}

TEST_F(MeshFile, RoundTripsThroughObjWithTextureAndHighlight) {
  Mesh mesh = MakeBox({0.1, 0.1, 0.1}, {1.0F, 0.5F, 1.0F});
  mesh.materials[0].specular = 0.25F;
  mesh.materials[0].shininess = 30.0F;
  for (const Eigen::Vector3f& p : mesh.vertices) {
    mesh.uv.emplace_back(p.x() * 10.0F + 0.5F, p.y() * 10.0F + 0.5F);
  }
  mesh.materials[0].texture = cv::Mat(2, 2, CV_8UC3);
  mesh.materials[0].texture.at<cv::Vec3b>(0, 0) = {200, 100, 0};  // RGB, at u = 1/4, v = 3/4
  mesh.materials[0].texture.at<cv::Vec3b>(0, 1) = {0, 0, 0};
  mesh.materials[0].texture.at<cv::Vec3b>(1, 0) = {0, 0, 50};
  mesh.materials[0].texture.at<cv::Vec3b>(1, 1) = {255, 255, 255};
  SaveObj(mesh, folder_);
  const Mesh again = LoadMesh(folder_ / "mesh.obj", kMetre);
  ASSERT_EQ(again.triangles.size(), 12U);
  ASSERT_EQ(again.vertices.size(), 8U);
  ASSERT_EQ(again.materials.size(), 1U);
  EXPECT_NEAR(again.materials[0].specular, 0.25F, 1e-6F);
  EXPECT_NEAR(again.materials[0].shininess, 30.0F, 1e-4F);
  EXPECT_EQ(again.materials[0].texture.at<cv::Vec3b>(0, 0), cv::Vec3b(200, 50, 0));
  // The upper face is x, y in [-5, 5] cm; the texel at v = 3/4 (y = 2.5 cm), u = 1/4 (x = -2.5 cm).
  for (int i = 0; i < 12; ++i) {
    Eigen::Matrix3f corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = again.vertices[again.triangles[i][k]];
    if (corners.row(2).minCoeff() < 0.04F) continue;
    const Eigen::Vector3f weights = corners.inverse() * Eigen::Vector3f(-0.025F, 0.025F, 0.05F);
    if (weights.minCoeff() < -1e-5F) continue;
    const Eigen::Vector3f color = ColorAt(again, i, weights) * 255.0F;
    EXPECT_NEAR(color.x(), 200.0F, 0.5F);
    EXPECT_NEAR(color.y(), 50.0F, 0.5F);
    EXPECT_NEAR(color.z(), 0.0F, 0.5F);
  }
}

TEST_F(MeshFile, ReadsATextureWhoseNameIsFollowedByABlank) {
  cv::imwrite((folder_ / "red.png").string(), cv::Mat(1, 1, CV_8UC3, cv::Scalar(0, 0, 255)));
  Write("m.mtl", "newmtl a\nmap_Kd red.png \n");
  const Mesh mesh =
      LoadMesh(Write("m.obj",
                     "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nvt 0 0\nvt 1 0\n"
                     "vt 0 1\nf 1/1 2/2 3/3\n"),
               kMetre);
  EXPECT_TRUE(ColorAt(mesh, 0, {0.3F, 0.3F, 0.4F}).isApprox(Eigen::Vector3f(1, 0, 0)));
}

TEST_F(MeshFile, ReadsVertexColors) {
  const Mesh mesh = LoadMesh(
      Write("c.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0 255 0 0\n0.1 0 0 255 0 0\n0 0.1 0 0 0 255\n3 0 1 2\n"),
      kMetre);
  EXPECT_TRUE(ColorAt(mesh, 0, {0.0F, 0.5F, 0.5F}).isApprox(Eigen::Vector3f(0.5F, 0, 0.5F)));
}

TEST_F(MeshFile, ReadsAnStlAndJoinsItsCorners) {
  const Mesh mesh = LoadMesh(
      Write("s.stl",
            "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 "
            "0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0.1 0 0\nvertex 0.1 0.1 "
            "0\nvertex 0 0.1 0\nendloop\nendfacet\nendsolid s\n"),
      kMetre);
  EXPECT_EQ(mesh.vertices.size(), 4U);
  EXPECT_EQ(mesh.triangles.size(), 2U);
}

std::string LittleEndian(std::uint32_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
  return bytes;
}

std::string Floats(const std::vector<float>& values) {
  std::string bytes;
  for (const float value : values) bytes += LittleEndian(std::bit_cast<std::uint32_t>(value));
  return bytes;
}

std::string Chunk(const std::string& type, std::string content, char padding) {
  while (content.size() % 4 != 0) content += padding;
  return LittleEndian(static_cast<std::uint32_t>(content.size())) + type + content;
}

/// A GLB file: one triangle whose image, 1 x 2 texels, is embedded as PNG: red above blue. It hangs
/// in a node that is moved by 1 m along x.
std::string TexturedGlb() {
  cv::Mat image(2, 1, CV_8UC3);
  image.at<cv::Vec3b>(0, 0) = {0, 0, 255};  // BGR, as OpenCV writes it
  image.at<cv::Vec3b>(1, 0) = {255, 0, 0};
  std::vector<unsigned char> png;
  cv::imencode(".png", image, png);
  const std::string positions = Floats({0, 0, 0, 0.1F, 0, 0, 0, 0.1F, 0});
  const std::string uv = Floats({0.5F, 0.25F, 0.5F, 0.25F, 0.5F, 0.25F});  // glTF: v points down
  const std::string binary = positions + uv + std::string(png.begin(), png.end());
  const std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
      R"("nodes":[{"mesh":0,"translation":[1,0,0]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],)"
      R"("materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],)"
      R"("textures":[{"source":0}],"images":[{"bufferView":2,"mimeType":"image/png"}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",)"
      R"("min":[0,0,0],"max":[0.1,0.1,0]},)"
      R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],)" +
      fmt::format(R"("bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":36}},)"
                  R"({{"buffer":0,"byteOffset":36,"byteLength":24}},)"
                  R"({{"buffer":0,"byteOffset":60,"byteLength":{}}}],)"
                  R"("buffers":[{{"byteLength":{}}}]}})",
                  png.size(), binary.size());
  const std::string chunks =
      Chunk("JSON", json, ' ') + Chunk(std::string("BIN\0", 4), binary, '\0');
  return "glTF" + LittleEndian(2) + LittleEndian(static_cast<std::uint32_t>(12 + chunks.size())) +
         chunks;
}

TEST_F(MeshFile, ReadsAGlbWithItsEmbeddedTextureAndNodeTransform) {
  const Mesh mesh = LoadMesh(Write("t.glb", TexturedGlb()), kMetre);
  ASSERT_EQ(mesh.triangles.size(), 1U);
  EXPECT_NEAR(Bounds(mesh).min().x(), 1.0, 1e-6);
  EXPECT_NEAR(Bounds(mesh).max().x(), 1.1, 1e-6);
  ASSERT_EQ(mesh.materials[0].texture.rows, 2);
  EXPECT_EQ(mesh.materials[0].texture.at<cv::Vec3b>(0, 0), cv::Vec3b(255, 0, 0));
  EXPECT_TRUE(ColorAt(mesh, 0, {0.2F, 0.3F, 0.5F}).isApprox(Eigen::Vector3f(1, 0, 0), 1e-3F));
}

TEST_F(MeshFile, RefusesWhatIsNoMeshAndNamesTheFile) {
  EXPECT_THROWS(LoadMesh(folder_ / "none.obj", kMetre), ConfigError,
                "none.obj: there is no such mesh file");
  EXPECT_THROWS(LoadMesh(folder_, kMetre), ConfigError, "there is no such mesh file");
  EXPECT_THROWS(LoadMesh(Write("a.txt", "hello"), kMetre), ConfigError,
                "a.txt: '.txt' is not a mesh format");
  EXPECT_THROWS(LoadMesh(Write("empty.obj", ""), kMetre), ConfigError, "empty.obj: it ");
  EXPECT_THROWS(LoadMesh(Write("text.obj", "this is no mesh\n"), kMetre), ConfigError,
                "text.obj: it ");
  EXPECT_THROWS(LoadMesh(Write("text.ply", "this is no mesh\n"), kMetre), ConfigError,
                "text.ply: it ");
  EXPECT_THROWS(LoadMesh(Write("text.glb", "this is no mesh\n"), kMetre), ConfigError,
                "text.glb: it ");
  EXPECT_THROWS(LoadMesh(Write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), kMetre), ConfigError,
                "points.obj: it ");
  EXPECT_THROWS(LoadMesh(Write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), kMetre),
                ConfigError, "flat.obj: it has no triangle");
}

TEST_F(MeshFile, RefusesATruncatedFile) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float "
      "y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_THROWS(LoadMesh(Write("cut.ply", header + std::string(20, '\1')), kMetre), ConfigError,
                "cut.ply: it is cut off after 1 of the 3 elements 'vertex' in its header");
  EXPECT_THROWS(LoadMesh(Write("cut_face.ply", header + std::string(36, '\0') + "\3\1"), kMetre),
                ConfigError, "cut_face.ply: it is cut off after 0 of the 1 elements 'face'");
  EXPECT_THROWS(LoadMesh(Write("cut_line.ply",
                               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                               "property float y\nproperty float z\nend_header\n0 0 0\n0 0 1\n"),
                         kMetre),
                ConfigError, "cut_line.ply: it is cut off after 2 of the 3 elements 'vertex'");
  EXPECT_THROWS(LoadMesh(Write("header.ply", header.substr(0, 50)), kMetre), ConfigError,
                "header.ply: it has no valid PLY header");
  EXPECT_THROWS(LoadMesh(Write("cut.obj", "v 0 0 0\nv 0.1 0 0\nf 1 2 3\n"), kMetre), ConfigError,
                "cut.obj: it ");
  EXPECT_THROWS(LoadMesh(Write("cut.glb", std::string("glTF\2\0\0\0\xff\0\0\0", 12)), kMetre),
                ConfigError, "cut.glb: it ");
}

TEST_F(MeshFile, RefusesAVertexThatIsNotFinite) {
  EXPECT_THROWS(LoadMesh(Write("nan.obj", "v 0 0 nan\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n"), kMetre),
                ConfigError, "nan.obj: vertex");
}

TEST_F(MeshFile, RefusesATextureThatIsMissing) {
  Write("m.mtl", "newmtl a\nmap_Kd none.png\n");
  EXPECT_THROWS(
      LoadMesh(Write("m.obj", std::string("mtllib m.mtl\nusemtl a\n") + kTriangle), kMetre),
      ConfigError, "none.png' cannot be read; put the image there or correct the material");
}

TEST(MeshData, LoadsARealScanWithItsTexture) {
  const char* data = std::getenv("SECONDLOOK_DATA");
  if (data == nullptr) GTEST_SKIP() << "SECONDLOOK_DATA is not set";
  const Mesh mug = LoadMesh(fs::path(data) / "ycb/025_mug/textured.obj", kMetre);
  EXPECT_EQ(mug.triangles.size(), 16378U);  // of 16384, 6 have no area
  EXPECT_EQ(mug.materials[0].texture.cols, 1024);
  EXPECT_NEAR(Diameter(mug), 0.17, 0.03);
  const fs::path dinosaur = fs::path(data) / "ppf/parasaurolophus_6700.ply";
  EXPECT_THROWS(LoadMesh(dinosaur, kMetre), ConfigError, "is its unit 'mm'");
  EXPECT_EQ(LoadMesh(dinosaur, LengthUnit::kMillimetre).triangles.size(), 9140U);
}

}  // namespace
}  // namespace secondlook::geometry
