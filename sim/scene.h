#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/error.h"
#include "lib/common/pose.h"
#include "lib/geometry/mesh.h"
#include "sim/renderer.h"

namespace secondlook::sim {

// A scene as its file says it (docs/scenes.md): world frame W with z up and the floor at z = 0,
// metres; degrees in keys that end in _deg. Colours are RGB in [0, 1].

/// The table; its top is the support plane. A plinth is a small tall table.
struct Table {
  Eigen::Vector2d size{1.2, 0.8};      ///< Of the top, along its x and y [m].
  double height{0.75};                 ///< Of the top surface above the floor [m].
  double thickness{0.03};              ///< Of the top [m].
  Eigen::Vector2d position{0.0, 0.0};  ///< Centre, in W [m].
  double yaw_deg{};
  bool solid{};  ///< True: a closed block down to the floor; false: four legs.
  Eigen::Vector3d color{0.62, 0.47, 0.32};

  template <class A>
  void Serialize(A* a) {
    a->Visit("size", &size);
    a->Visit("height", &height);
    a->Visit("thickness", &thickness);
    a->Visit("position", &position);
    a->Visit("yaw_deg", &yaw_deg);
    a->Visit("solid", &solid);
    a->Visit("color", &color);
  }
  void Validate() const;

  /// True when the point (x, y) in W lies on the top.
  bool Contains(const Eigen::Vector2d& p_W) const;
};

/// What the mission's object database knows of an object.
enum class Role {
  kKnown,     ///< It holds its model.
  kUnknown,   ///< It does not; the object is to be called unknown.
  kObstacle,  ///< Neither: not on the table, only in the way.
};

/// An object made from a mesh file.
struct SceneObject {
  std::string mesh;              ///< The file. In a scene file, relative to that file's folder.
  std::string unit{"m"};         ///< Of the mesh file: m or mm.
  std::string name;              ///< What the truth calls it; a known one's name in the database.
  std::string role{"known"};     ///< known, unknown or obstacle.
  std::vector<double> position;  ///< [x, y] in W: dropped onto the table. [x, y, z]: just there.
  double roll_deg{};             ///< The mesh is turned by Rz(yaw) Ry(pitch) Rx(roll) first.
  double pitch_deg{};
  double yaw_deg{};

  template <class A>
  void Serialize(A* a) {
    a->Visit("mesh", &mesh);
    a->Visit("unit", &unit);
    a->Visit("name", &name);
    a->Visit("role", &role);
    a->Visit("position", &position);
    a->Visit("roll_deg", &roll_deg);
    a->Visit("pitch_deg", &pitch_deg);
    a->Visit("yaw_deg", &yaw_deg);
  }
  void Validate() const;
};

/// A plain obstacle.
struct SceneBox {
  std::string name{"box"};
  Eigen::Vector3d size{0.4, 0.4, 0.4};      ///< [m]
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< Centre of the bottom face, in W [m].
  double yaw_deg{};
  Eigen::Vector3d color{0.5, 0.4, 0.3};

  template <class A>
  void Serialize(A* a) {
    a->Visit("name", &name);
    a->Visit("size", &size);
    a->Visit("position", &position);
    a->Visit("yaw_deg", &yaw_deg);
    a->Visit("color", &color);
  }
  void Validate() const;
};

/// An upright cylinder that goes to and fro along its waypoints.
struct MovingObstacle {
  std::string name{"person"};
  double radius{0.25};                     ///< [m]
  double height{1.7};                      ///< [m]
  std::vector<Eigen::Vector2d> waypoints;  ///< In W [m]; it starts at the first.
  double speed{0.5};                       ///< [m/s]
  Eigen::Vector3d color{0.3, 0.3, 0.5};

  template <class A>
  void Serialize(A* a) {
    a->Visit("name", &name);
    a->Visit("radius", &radius);
    a->Visit("height", &height);
    a->Visit("waypoints", &waypoints);
    a->Visit("speed", &speed);
    a->Visit("color", &color);
  }
  void Validate() const;
};

/// The floor, centred at the origin of W.
struct Floor {
  Eigen::Vector2d size{7.0, 6.0};  ///< [m]
  Eigen::Vector3d color{0.45, 0.45, 0.47};

  template <class A>
  void Serialize(A* a) {
    a->Visit("size", &size);
    a->Visit("color", &color);
  }
  void Validate() const;
};

/// Walls around the floor.
struct Walls {
  double height{2.5};  ///< [m]
  Eigen::Vector3d color{0.8, 0.8, 0.76};

  template <class A>
  void Serialize(A* a) {
    a->Visit("height", &height);
    a->Visit("color", &color);
  }
  void Validate() const;
};

/// Where the base starts.
struct RobotStart {
  Eigen::Vector2d position{-1.5, 0.0};  ///< In W [m].
  double yaw_deg{};

  template <class A>
  void Serialize(A* a) {
    a->Visit("position", &position);
    a->Visit("yaw_deg", &yaw_deg);
  }
};

/// All there is in the simulated room.
struct Scene {
  std::string name{"scene"};
  Table table;
  std::vector<SceneObject> objects;
  std::vector<SceneBox> boxes;
  std::vector<MovingObstacle> moving_obstacles;
  std::vector<Light> lights{Light{}};
  double ambient{0.35};
  Floor floor;
  std::optional<Walls> walls;
  RobotStart robot;
  std::string noise;  ///< YAML of the NoiseConfig keys that the scene overrides; empty: none.

  template <class A>
  void Serialize(A* a) {
    a->Visit("name", &name);
    a->Visit("table", &table);
    a->Visit("objects", &objects);
    a->Visit("boxes", &boxes);
    a->Visit("moving_obstacles", &moving_obstacles);
    a->Visit("lights", &lights);
    a->Visit("ambient", &ambient);
    a->Visit("floor", &floor);
    a->Visit("walls", &walls);
    a->Visit("robot", &robot);
  }

  /// @throws ConfigError naming what is wrong, e.g. an object beside the table.
  void Validate() const;
};

/// Reads a scene file. The mesh files in the result are relative to the working folder.
/// @throws ConfigError with place and key for whatever is wrong with it.
Scene LoadScene(const std::filesystem::path& file);

/// Writes `scene` so that LoadScene reads it back, mesh files relative to the folder of `file`.
/// @throws ConfigError when that cannot be written.
void SaveScene(const Scene& scene, const std::filesystem::path& file);

/// The YAML of `scene`, mesh files as they stand there.
std::string SceneToYaml(const Scene& scene);

/// An object with its mesh, where it stands.
struct PlacedObject {
  std::string name;
  Role role{Role::kKnown};
  Pose X_WM{Pose::Identity()};
  geometry::Mesh mesh;
};

/// The pose of `mesh` as `object` says: dropped until its lowest point touches the table's top, or
/// at the height given.
Pose PlaceOnTable(const SceneObject& object, const geometry::Mesh& mesh, const Table& table);

/// Loads the meshes of all objects and places them, in the order of the scene.
/// @throws ConfigError naming the object whose mesh cannot be read.
std::vector<PlacedObject> PlaceObjects(const Scene& scene);

}  // namespace secondlook::sim
