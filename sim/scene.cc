#include "sim/scene.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "lib/common/files.h"
#include "lib/common/yaml_reader.h"
#include "sim/noise.h"

namespace secondlook::sim {
namespace {

namespace fs = std::filesystem;
constexpr double kRadians = std::numbers::pi / 180.0;

void RequirePositive(const char* key, double value) {
  if (!(value > 0.0)) Throw<ConfigError>("'{}' = {} must be more than 0", key, value);
}

void RequireColor(const Eigen::Vector3d& color) {
  if (color.minCoeff() >= 0.0 && color.maxCoeff() <= 1.0) return;
  Throw<ConfigError>("'color' = [{}, {}, {}] must lie between 0 and 1", color.x(), color.y(),
                     color.z());
}

Role ParseRole(const std::string& text) {
  if (text == "known") return Role::kKnown;
  if (text == "unknown") return Role::kUnknown;
  if (text == "obstacle") return Role::kObstacle;
  Throw<ConfigError>("'role' = '{}' must be known, unknown or obstacle", text);
}

/// The 'noise' of the scene as text, checked key by key.
std::string ReadNoise(const YamlLayer& layer) {
  const YAML::Node node = layer.node["noise"];
  if (!node || node.IsNull() || (node.IsMap() && node.size() == 0)) return "";
  NoiseConfig noise;
  YamlReader(node, layer.source, "noise").Read(&noise);
  YAML::Emitter emitter;
  emitter << YAML::Flow << node;
  return emitter.c_str();
}

}  // namespace

void Table::Validate() const {
  RequirePositive("size", size.minCoeff());
  RequirePositive("thickness", thickness);
  if (!(height > thickness)) {
    Throw<ConfigError>("'height' = {} must be more than the thickness, {}", height, thickness);
  }
  RequireColor(color);
}

bool Table::Contains(const Eigen::Vector2d& p_W) const {
  const Eigen::Vector2d p_T = Eigen::Rotation2Dd(-yaw_deg * kRadians) * (p_W - position);
  return (p_T.cwiseAbs() - size / 2).maxCoeff() <= 0.0;
}

void SceneObject::Validate() const {
  if (mesh.empty()) Throw<ConfigError>("an object needs 'mesh', the file of its mesh");
  if (name.empty()) Throw<ConfigError>("an object needs 'name'; its mesh is '{}'", mesh);
  if (position.size() != 2 && position.size() != 3) {
    Throw<ConfigError>("'position' of '{}' must be [x, y] on the table or [x, y, z]", name);
  }
  if (unit != "m" && unit != "mm") {
    Throw<ConfigError>("'unit' = '{}' of '{}' must be m or mm", unit, name);
  }
  ParseRole(role);
}

void SceneBox::Validate() const {
  RequirePositive("size", size.minCoeff());
  RequireColor(color);
}

void MovingObstacle::Validate() const {
  RequirePositive("radius", radius);
  RequirePositive("height", height);
  RequirePositive("speed", speed);
  RequireColor(color);
  if (waypoints.empty()) Throw<ConfigError>("'{}' needs 'waypoints', one at least", name);
}

void Floor::Validate() const {
  RequirePositive("size", size.minCoeff());
  RequireColor(color);
}

void Walls::Validate() const {
  RequirePositive("height", height);
  RequireColor(color);
}

void Scene::Validate() const {
  if (!(ambient >= 0.0)) Throw<ConfigError>("'ambient' = {} must be 0 or more", ambient);
  if (lights.size() > Lighting::kMaxLights) {
    Throw<ConfigError>("'lights' has {} entries; a scene may have {}", lights.size(),
                       Lighting::kMaxLights);
  }
  for (const SceneObject& object : objects) {
    if (object.position.size() != 2) continue;
    if (table.Contains({object.position[0], object.position[1]})) continue;
    Throw<ConfigError>(
        "object '{}' at [{}, {}] is beside the table; give it a place on the top, or "
        "a position [x, y, z]",
        object.name, object.position[0], object.position[1]);
  }
}

Scene LoadScene(const fs::path& file) {
  YamlLayer layer = ReadYamlFile(file);
  if (layer.node.IsMap() && !layer.node["table"]) {
    Throw<ConfigError>(
        "{}: the scene has no table; add 'table: {{size: [1.2, 0.8], height: 0.75}}'",
        file.string());
  }
  Scene scene;
  if (layer.node.IsMap()) {
    scene.noise = ReadNoise(layer);
    layer.node.remove("noise");
  }
  ApplyLayer(layer, &scene);
  for (SceneObject& object : scene.objects) {
    object.mesh = (file.parent_path() / object.mesh).lexically_normal().string();
  }
  return scene;
}

std::string SceneToYaml(const Scene& scene) {
  std::string text = ToYaml(scene);
  if (!scene.noise.empty()) text += "noise: " + scene.noise + "\n";
  return text;
}

void SaveScene(const Scene& scene, const fs::path& file) {
  Scene moved = scene;
  const fs::path folder = fs::absolute(file).lexically_normal().parent_path();
  for (SceneObject& object : moved.objects) {
    object.mesh = fs::absolute(object.mesh).lexically_normal().lexically_relative(folder).string();
  }
  WriteFile(file, SceneToYaml(moved));
}

Pose PlaceOnTable(const SceneObject& object, const geometry::Mesh& mesh, const Table& table) {
  Pose X_WM = Pose::Identity();
  X_WM.linear() = RotationFromRollPitchYaw(object.roll_deg * kRadians, object.pitch_deg * kRadians,
                                           object.yaw_deg * kRadians);
  double lowest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3f& p_MV : mesh.vertices) {
    lowest = std::min(lowest, X_WM.linear().row(2).dot(p_MV.cast<double>()));
  }
  const bool dropped = object.position.size() == 2;
  X_WM.translation() = Eigen::Vector3d(object.position[0], object.position[1],
                                       dropped ? table.height - lowest : object.position[2]);
  return X_WM;
}

std::vector<PlacedObject> PlaceObjects(const Scene& scene) {
  std::vector<PlacedObject> placed;
  for (const SceneObject& object : scene.objects) {
    try {
      PlacedObject& entry = placed.emplace_back();
      entry.name = object.name;
      entry.role = ParseRole(object.role);
      entry.mesh = geometry::LoadMesh(object.mesh, geometry::ParseLengthUnit(object.unit));
      entry.X_WM = PlaceOnTable(object, entry.mesh, scene.table);
    } catch (const Error& error) {
      Throw<ConfigError>("scene '{}', object '{}': {}", scene.name, object.name, error.what());
    }
  }
  return placed;
}

}  // namespace secondlook::sim
