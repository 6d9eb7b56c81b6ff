#pragma once

#include <string>

#include "lib/common/files.h"
#include "lib/geometry/mesh.h"
#include "lib/world/object_database.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::testing {

/// A folder with a configuration, a scene and a database of one model, a red block of 0.1 x 0.15 x
/// 0.2 m: the least that a mission needs.
class SmallWorld {
 public:
  SmallWorld() {
    geometry::SaveObj(geometry::MakeBox({0.1, 0.15, 0.2}, {0.8, 0.1, 0.1}), folder_ / "mesh");
    world::AddModel(folder_ / "mesh" / "mesh.obj", geometry::LengthUnit::kMetre, "block", models());
    WriteFile(folder_ / "scene.yaml",
              "table: {size: [1.2, 0.8], height: 0.75}\nobjects:\n  - {mesh: mesh/mesh.obj, unit: "
              "m, name: block, position: [0, 0]}\n");
    WriteFile(config(), "robot: !Sim\n  scene: scene.yaml\nmodels: models\n");
  }

  /// From now on the robot stands before a small table, has an arm and looks by it alone: no place
  /// for the base is near enough, and the arm may go where nobody has looked.
  void LookByArm() const {
    WriteFile(folder_ / "scene.yaml",
              "table: {size: [0.5, 0.4], height: 0.75}\nobjects:\n  - {mesh: mesh/mesh.obj, unit: "
              "m, name: block, position: [-0.1, 0]}\nrobot: {position: [-0.75, 0.0]}\n");
    WriteFile(config(), "robot: !Sim\n  scene: scene.yaml\n  arm: {urdf: " +
                            std::filesystem::absolute("sim/robots/arm.urdf").string() +
                            "}\nmodels: models\nmission: {looks: {views: {inner_radius_m: 6, "
                            "outer_radius_m: 6, placed: 0}, arm: {obstacles: {avoid_unknown: "
                            "false}}}}\n");
  }

  std::filesystem::path config() const { return folder_ / "config.yaml"; }
  std::filesystem::path models() const { return folder_ / "models"; }
  std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

 private:
  TemporaryFolder folder_;
};

}  // namespace secondlook::testing
