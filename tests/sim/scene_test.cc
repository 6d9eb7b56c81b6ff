#include "sim/scene.h"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "tests/support/expect_throws.h"

namespace secondlook::sim {
namespace {

namespace fs = std::filesystem;

/// A folder of its own for each test, removed afterwards.
class SceneFile : public ::testing::Test {
 protected:
  SceneFile()
      : folder_(fs::path(::testing::TempDir()) /
                (std::string("scene_") +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    geometry::SaveObj(geometry::MakeBox({0.1, 0.2, 0.3}, {1, 0, 0}), folder_ / "block");
  }
  ~SceneFile() override { fs::remove_all(folder_); }

  Scene Load(const std::string& yaml) const {
    WriteFile(folder_ / "s.yaml", yaml);
    return LoadScene(folder_ / "s.yaml");
  }

  fs::path folder_;
};

constexpr const char* kTable = "table: {size: [1, 1], height: 0.7}\n";
const std::string kBlock = "mesh: block/mesh.obj, name: block";

TEST_F(SceneFile, ReadsAllItsParts) {
  const Scene scene = Load(
      "name: all\ntable: {size: [1, 0.5], height: 0.7, thickness: 0.02, position: [1, 2], yaw_deg: "
      "90, solid: true, color: [0.1, 0.2, 0.3]}\nobjects:\n  - {mesh: block/mesh.obj, unit: m, "
      "name: block, role: unknown, position: [1, 2], yaw_deg: 40}\nboxes:\n  - {name: crate, size: "
      "[0.4, 0.4, 0.5], position: [1.8, 1, 0], yaw_deg: 10, color: [0.5, 0.4, 0.3]}\n"
      "moving_obstacles:\n  - {name: person, radius: 0.25, height: 1.7, waypoints: [[2, 2], [-2, "
      "2]], speed: 0.5, color: [0.3, 0.3, 0.5]}\nlights:\n  - {position: [1.5, -1, 2.6], color: "
      "[1, 1, 0.95], intensity: 0.8}\nambient: 0.35\nfloor: {size: [7, 6], color: [0.4, 0.4, 0.5]}"
      "\nwalls: {height: 2.5, color: [0.8, 0.8, 0.76]}\nrobot: {position: [-1.5, -0.4], yaw_deg: "
      "15}\nnoise: {depth_axial_scale: 0}\n");
  EXPECT_EQ(scene.name, "all");
  EXPECT_TRUE(scene.table.solid);
  EXPECT_EQ(scene.objects.at(0).role, "unknown");
  EXPECT_EQ(fs::path(scene.objects.at(0).mesh), folder_ / "block/mesh.obj");
  EXPECT_EQ(scene.boxes.at(0).size.z(), 0.5);
  EXPECT_EQ(scene.moving_obstacles.at(0).waypoints.at(1).x(), -2.0);
  EXPECT_EQ(scene.lights.at(0).position.z(), 2.6);
  EXPECT_EQ(scene.walls.value().height, 2.5);
  EXPECT_EQ(scene.robot.yaw_deg, 15.0);
  EXPECT_EQ(scene.noise, "{depth_axial_scale: 0}");
}

TEST_F(SceneFile, IsWrittenSoThatItReadsBack) {
  Scene scene = Load(std::string(kTable) + "objects: [{" + kBlock +
                     ", position: [0.1, 0.2], roll_deg: 90}]\nnoise: {color_sigma: 1}\n");
  scene.moving_obstacles.push_back({.waypoints = {{1, 2}, {3, 4}}});
  SaveScene(scene, folder_ / "sub" / "again.yaml");
  const Scene again = LoadScene(folder_ / "sub" / "again.yaml");
  EXPECT_EQ(SceneToYaml(again), SceneToYaml(scene));
  EXPECT_EQ(again.noise, "{color_sigma: 1}");
  EXPECT_EQ(PlaceObjects(again).size(), 1U);
}

TEST_F(SceneFile, SaysHowToGiveItATable) {
  EXPECT_THROWS(Load("name: bare\n"), ConfigError,
                "s.yaml: the scene has no table; add 'table: {size: [1.2, 0.8], height: 0.75}'");
}

TEST_F(SceneFile, NamesThePlaceAndKeyOfEachMistake) {
  const std::string table = kTable;
  const auto object = [&](const std::string& fields) {
    return table + "objects:\n  - {" + fields + "}\n";
  };
  EXPECT_THROWS(Load(table + "objcts: []\n"), ConfigError, "s.yaml:2:1: unknown key 'objcts'");
  EXPECT_THROWS(Load("table: {size: [1], height: 0.7}"), ConfigError,
                "s.yaml:1:15: 'table.size' must be a list of 2 values");
  EXPECT_THROWS(Load("table: {size: [0, 1], height: 0.7}"), ConfigError,
                "s.yaml:1:8: 'size' = 0 must be more than 0");
  EXPECT_THROWS(Load("table: {height: 0.02}"), ConfigError, "'height' = 0.02 must be more than");
  EXPECT_THROWS(Load(object("name: mug, position: [0, 0]")), ConfigError,
                "s.yaml:3:5: an object needs 'mesh'");
  EXPECT_THROWS(Load(object("mesh: m.obj, position: [0, 0]")), ConfigError,
                "an object needs 'name'; its mesh is 'm.obj'");
  EXPECT_THROWS(Load(object(kBlock)), ConfigError, "'position' of 'block' must be [x, y]");
  EXPECT_THROWS(Load(object(kBlock + ", position: [0, 0], role: friend")), ConfigError,
                "'role' = 'friend' must be known, unknown or obstacle");
  EXPECT_THROWS(Load(object(kBlock + ", position: [0, 0], unit: cm")), ConfigError,
                "'unit' = 'cm' of 'block' must be m or mm");
  EXPECT_THROWS(Load(object(kBlock + ", position: [0.6, 0]")), ConfigError,
                "object 'block' at [0.6, 0] is beside the table");
  EXPECT_THROWS(Load(table + "noise: {depth_axial: 0}\n"), ConfigError,
                "s.yaml:2:9: unknown key 'noise.depth_axial'");
  EXPECT_THROWS(Load(table + "moving_obstacles: [{name: cat}]\n"), ConfigError,
                "'cat' needs 'waypoints'");
  EXPECT_THROWS(Load(table + "floor: {color: [2, 0, 0]}\n"), ConfigError,
                "'color' = [2, 0, 0] must lie between 0 and 1");
  EXPECT_THROWS(Load("[1, 2]"), ConfigError, "'the file' must be a map");
  EXPECT_THROWS(LoadScene(folder_ / "none.yaml"), ConfigError, "none.yaml");
}

TEST_F(SceneFile, NamesTheObjectWhoseMeshIsMissingOrInAnotherUnit) {
  Scene scene =
      Load(std::string(kTable) + "objects: [{mesh: no.obj, name: mug, position: [0, 0]}]");
  EXPECT_THROWS(PlaceObjects(scene), ConfigError, "object 'mug': ");
  EXPECT_THROWS(PlaceObjects(scene), ConfigError, "no.obj: there is no such mesh file");
  scene = Load(std::string(kTable) + "objects: [{" + kBlock + ", unit: mm, position: [0, 0]}]");
  EXPECT_THROWS(PlaceObjects(scene), ConfigError, "is its unit 'm' rather than 'mm'?");
}

TEST_F(SceneFile, DropsAnObjectUntilItsLowestPointTouchesTheTop) {
  // The block measures 0.1 x 0.2 x 0.3 about its centre. Upright it stands 0.15 above the top;
  // rolled by 90 degrees its y axis points up: 0.1 above.
  const Scene scene = Load(std::string(kTable) + "objects:\n  - {" + kBlock +
                           ", position: [0.1, 0.2], yaw_deg: 90}\n  - {" + kBlock +
                           ", position: [0.1, 0.2], roll_deg: 90, yaw_deg: 90}\n  - {" + kBlock +
                           ", position: [3, 0, 0.15], role: obstacle}\n");
  const std::vector<PlacedObject> placed = PlaceObjects(scene);
  EXPECT_NEAR(placed[0].X_WM.translation().z(), 0.85, 1e-6);
  EXPECT_NEAR(placed[1].X_WM.translation().z(), 0.80, 1e-6);
  EXPECT_NEAR(placed[2].X_WM.translation().z(), 0.15, 1e-6);
  EXPECT_EQ(placed[2].role, Role::kObstacle);
  // Rz(90) Rx(90): the model's y axis points up, its z axis along W's x.
  EXPECT_TRUE(placed[1].X_WM.linear().col(1).isApprox(Eigen::Vector3d::UnitZ(), 1e-9));
  EXPECT_TRUE(placed[1].X_WM.linear().col(2).isApprox(Eigen::Vector3d::UnitX(), 1e-9));
}

TEST(Table, KnowsWhatLiesOnIt) {
  Table table;
  table.size = {2.0, 0.5};
  table.position = {1.0, 1.0};
  table.yaw_deg = 90.0;
  EXPECT_TRUE(table.Contains({1.2, 1.9}));
  EXPECT_FALSE(table.Contains({1.9, 1.2}));
}

TEST(ShippedScenes, AllLoad) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator("sim/scenes")) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(LoadScene(entry.path()).Validate()) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 4);
}

}  // namespace
}  // namespace secondlook::sim
