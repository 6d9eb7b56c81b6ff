#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/files.h"
#include "tests/support/program.h"
#include "tests/support/small_world.h"

namespace secondlook {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramResult;
using testing::RunProgram;

class Check : public ::testing::Test {
 protected:
  ProgramResult Run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"check", "--config", world_.config().string()};
    for (const std::string& set : more) arguments.insert(arguments.end(), {"--set", set});
    return RunProgram(arguments);
  }

  testing::SmallWorld world_;
};

TEST_F(Check, SaysOfEachThingThatItIsWell) {
  const ProgramResult result = Run();
  EXPECT_EQ(result.status, 0) << result.out;
  EXPECT_THAT(result.out, Not(HasSubstr("WRONG")));
  EXPECT_THAT(result.out, HasSubstr("'block': 0.100 x 0.150 x 0.200 m, 12 triangles"));
  EXPECT_THAT(result.out, ContainsRegex("ok +scene +.*scene.yaml: 1 objects"));
  EXPECT_THAT(result.out, HasSubstr("the camera sits at (0.000, 0.000, 1.250) m in the base"));
  EXPECT_THAT(result.out,
              HasSubstr("'head': 640 x 480 pixels, 58 x 45 deg, depth from 0.5 to 6 m"));
  EXPECT_THAT(result.out, ContainsRegex("ok +frame +'head': frame 1 came; [1-9][0-9]* % of its"));
  EXPECT_THAT(result.out, ContainsRegex("ok +pan-tilt +'head': at pan "));
  EXPECT_THAT(result.out, ContainsRegex("ok +base +'base': at \\("));
}

TEST_F(Check, CountsTheModelsThatMissionsHaveMade) {
  const std::string learned = (world_ / "learned").string();
  EXPECT_THAT(Run({"learned=" + learned}).out, ContainsRegex("ok +learned +.*: 0 of them"));
  geometry::SaveObj(geometry::MakeBox({0.1, 0.1, 0.1}, {0.1, 0.8, 0.1}), world_ / "made");
  world::AddModel(world_ / "made" / "mesh.obj", geometry::LengthUnit::kMetre, "block", learned);
  const ProgramResult twice = Run({"learned=" + learned});
  EXPECT_EQ(twice.status, 2) << twice.out;
  EXPECT_THAT(twice.out, HasSubstr("'block' is a model in both " + world_.models().string() +
                                   " (models) and " + learned + " (learned): remove one"));
}

TEST_F(Check, NamesTheArmAndTheCameraInItsHand) {
  const std::string arm = "robot.arm={urdf: sim/robots/arm.urdf";
  const ProgramResult result = Run({arm + "}"});
  EXPECT_EQ(result.status, 0) << result.out;
  EXPECT_THAT(result.out, ContainsRegex("ok +arm +'arm': 7 joints, at 80, 45, 0, 112, "));
  EXPECT_THAT(result.out, ContainsRegex("ok +hand camera +'hand': 640 x 480 pixels, with depth"));
  EXPECT_THAT(result.out, ContainsRegex("ok +hand frame +'hand': frame 1 came"));

  EXPECT_THAT(result.out, ContainsRegex("ok +same table +not compared, as the hand's camera"));

  const ProgramResult wrong = Run({arm + ", tip: gripper}"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.out, ContainsRegex("WRONG +robot +robot 'arm' has no link 'gripper'"));
}

TEST_F(Check, ComparesWhereTheCamerasOfHeadAndHandSeeTheTable) {
  // The hand is held up and looks ahead and down, as the head does.
  const std::string home =
      "robot.arm={urdf: sim/robots/arm.urdf, home_deg: [0, -10, 0, -70, 0, 52, 0]}";
  const ProgramResult same = Run({home});
  EXPECT_EQ(same.status, 0) << same.out;
  EXPECT_THAT(same.out, ContainsRegex("ok +same table +the hand's camera sees it [0-9]"));

  WriteFile(world_ / "c.yaml",
            "X_BH0: {position: [0, 0, 1.25]}\nX_HC: {rpy_deg: [-90, 0, -90]}\n"
            "X_EC: {position: [0.06, 0, 0.032], rpy_deg: [4, 4, 0]}\n");
  const ProgramResult off = Run({home, "robot.calibration=" + (world_ / "c.yaml").string()});
  EXPECT_EQ(off.status, 3) << off.out;
  EXPECT_THAT(off.out, ContainsRegex("WRONG +same table +the hand's camera sees it [0-9.]+ mm "));
  EXPECT_THAT(off.out, HasSubstr("calibrate both with `secondlook calibrate --hand`"));
}

TEST_F(Check, FindsARobotOrAPersonThatWouldStandInSomething) {
  const std::string scene = ReadFile(world_ / "scene.yaml");
  const auto with = [&](const std::string& more) {
    WriteFile(world_ / "scene.yaml", scene + more + "\n");
    return Run();
  };
  const ProgramResult in_table = with("robot: {position: [0.7, 0.0]}");
  EXPECT_EQ(in_table.status, 2);
  EXPECT_THAT(in_table.out, ContainsRegex("WRONG +scene +the robot of 0.28 m radius starts at "
                                          "\\[0.7, 0\\], which is within 'table'; move one"));
  EXPECT_THAT(with("robot: {position: [9.0, 0.0]}").out,
              HasSubstr("the robot starts at [9, 0], which is off the floor of 7 x 6 m"));
  EXPECT_THAT(with("moving_obstacles: [{waypoints: [[-1.4, 0.0], [2.0, 2.0]]}]").out,
              HasSubstr("'person' starts at [-1.4, 0], which is within the robot; move one"));
  EXPECT_THAT(with("moving_obstacles: [{waypoints: [[0.0, 0.5]]}]").out,
              HasSubstr("'person' of 0.25 m radius starts at [0, 0.5], which is within 'table'"));
  EXPECT_EQ(with("moving_obstacles: [{waypoints: [[2.0, 2.0]]}]").status, 0);
}

TEST_F(Check, GoesOnAfterTheFirstFaultAndListsAll) {
  // One model changed behind the database's back, one with a mesh that is none.
  std::filesystem::copy(world_.models() / "block", world_.models() / "another",
                        std::filesystem::copy_options::recursive);
  WriteFile(world_.models() / "another" / "mesh.obj", "changed\n");
  WriteFile(world_.models() / "broken" / "model.yaml", "format: 7\n");
  const ProgramResult result = Run({"robot.camera_fault=nan"});
  EXPECT_EQ(result.status, 2) << "wrong input weighs more than a device";
  EXPECT_THAT(result.out, ContainsRegex("WRONG +model +.*another.*they have changed; remove the"));
  EXPECT_THAT(result.out, ContainsRegex("WRONG +model +.*broken.*format 7; this program reads"));
  EXPECT_THAT(result.out, ContainsRegex("ok +model +'block'"));
  EXPECT_THAT(result.out, ContainsRegex("WRONG +frame +camera 'head': no usable depth"));
  EXPECT_THAT(result.out, ContainsRegex("ok +base"));
}

TEST_F(Check, TellsADeviceThatFailsFromWrongInput) {
  const ProgramResult nan = Run({"robot.camera_fault=nan"});
  EXPECT_EQ(nan.status, 3);
  EXPECT_THAT(nan.out, HasSubstr("no pixel of frame 1 has any; check its projector and driver"));
  const ProgramResult nothing = Run({"robot.camera_fault=nothing"});
  EXPECT_EQ(nothing.status, 3);
  EXPECT_THAT(nothing.out, HasSubstr("camera 'head': no frame in 3 tries of 1 s"));
  const ProgramResult lost = Run({"robot.camera_fault=lost"});
  EXPECT_EQ(lost.status, 3);
  EXPECT_THAT(lost.out, HasSubstr("camera 'head': the device is lost"));
}

TEST_F(Check, FindsAConfigurationThatCannotBeRead) {
  const ProgramResult result = Run({"task.confidence=2"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.out, ContainsRegex("WRONG +config +--set task.confidence=2: "));
}

TEST_F(Check, FindsAnObjectThatIsCalledKnownAndIsNot) {
  WriteFile(world_ / "scene.yaml",
            "table: {}\nobjects:\n  - {mesh: mesh/mesh.obj, name: brick, position: [0, 0]}\n");
  const ProgramResult result = Run();
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.out, HasSubstr("object 'brick' has the role known, but no model has this"));
}

TEST_F(Check, FindsAWantedClassThatNobodyKnows) {
  const ProgramResult result = Run({"task.wanted.unicorn=0.9"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.out, ContainsRegex("WRONG +task +task.wanted names 'unicorn'"));
}

}  // namespace
}  // namespace secondlook
