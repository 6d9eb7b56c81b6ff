// What is wrong with the input is said with its place, and ends in exit status 2 or 3.

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/files.h"
#include "tests/support/program.h"
#include "tests/support/small_world.h"

namespace secondlook {
namespace {

using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::RunProgram;

class BadInput : public ::testing::Test {
 protected:
  /// `run` with the configuration and `more`.
  ProgramResult Run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"run", "--config", world_.config().string(), "--lcm-url",
                                       "none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  ProgramResult RunWithConfig(const std::string& yaml) const {
    WriteFile(world_.config(), yaml);
    return Run();
  }

  void Expect(const ProgramResult& result, int status, const std::string& message) const {
    EXPECT_EQ(result.status, status) << result.err;
    EXPECT_THAT(result.err, HasSubstr(message));
  }

  testing::SmallWorld world_;
};

TEST_F(BadInput, NamesAnUnknownKeyWithItsPlace) {
  const ProgramResult result = RunWithConfig("models: models\nmission:\n  lookz: {}\n");
  Expect(
      result, 2,
      "config.yaml:3:3: unknown key 'mission.lookz'; known here: understanding, looks, modelling");
}

TEST_F(BadInput, NamesAWrongTypeWithItsPlace) {
  Expect(RunWithConfig("models: models\nseed: many\n"), 2,
         "config.yaml:2:7: 'seed' must be a whole number that is not negative");
}

TEST_F(BadInput, NamesAnUnknownBackendAndThoseThereAre) {
  Expect(RunWithConfig("robot: !Kinect {}\nmodels: models\n"), 2,
         "config.yaml:1:8: 'robot' has tag '!Kinect'; expected one of !Sim");
}

TEST_F(BadInput, NamesAMissingConfiguration) {
  Expect(RunProgram({"run", "--config", (world_ / "none.yaml").string()}), 2,
         "none.yaml: cannot be read: No such file or directory");
}

TEST_F(BadInput, NamesMissingModelsAndScene) {
  Expect(RunWithConfig("robot: !Sim {scene: scene.yaml}\n"), 2, "config.yaml: 'models' is missing");
  Expect(RunWithConfig("models: models\n"), 2, "config.yaml: 'robot.scene' is missing");
  Expect(Run({"--set", "robot.scene=none.yaml", "--set", "models=" + world_.models().string()}), 2,
         "none.yaml: cannot be read: No such file or directory");
}

TEST_F(BadInput, NamesAModelFolderThatIsMissingOrEmpty) {
  Expect(Run({"--set", "models=nowhere"}), 2, "nowhere: no such folder of models");
  MakeWritableFolder(world_ / "empty");
  Expect(Run({"--set", "models=" + (world_ / "empty").string()}), 2,
         "empty: no models: there is no sub-folder with a model.yaml; add one with 'secondlook "
         "model add'");
}

TEST_F(BadInput, NamesAMeshThatIsNone) {
  WriteFile(world_ / "text.obj", "no mesh at all\n");
  Expect(RunProgram({"model", "add", "--mesh", (world_ / "text.obj").string(), "--unit", "m",
                     "--name", "text", "--models", world_.models().string()}),
         2, "text.obj: it is not a readable mesh");
  WriteFile(world_ / "mesh" / "mesh.obj", "no mesh at all\n");
  Expect(Run(), 2, "object 'block': ");
  EXPECT_THAT(Run().err, HasSubstr("mesh.obj: it is not a readable mesh"));
}

TEST_F(BadInput, NamesAMeshInMillimetresThatWasDeclaredAsMetres) {
  geometry::SaveObj(geometry::MakeBox({60.0, 100.0, 150.0}, {1, 0, 0}), world_ / "mm");
  const std::string mesh = (world_ / "mm" / "mesh.obj").string();
  const auto add = [&](const std::string& unit) {
    return RunProgram({"model", "add", "--mesh", mesh, "--unit", unit, "--name", "tall", "--models",
                       world_.models().string()});
  };
  Expect(add("m"), 2,
         "mesh.obj: it measures 190 m from corner to corner, and a model must lie between");
  EXPECT_THAT(add("m").err, HasSubstr("is its unit 'mm' rather than 'm'?"));
  EXPECT_EQ(add("mm").status, 0);
}

TEST_F(BadInput, NamesASecondModelOfTheSameName) {
  Expect(RunProgram({"model", "add", "--mesh", (world_ / "mesh" / "mesh.obj").string(), "--unit",
                     "m", "--name", "block", "--models", world_.models().string()}),
         2, "there is a model of this name already; remove it first or choose another name");
  std::filesystem::copy(world_.models() / "block", world_.models() / "copy",
                        std::filesystem::copy_options::recursive);
  Expect(Run(), 2, "two objects are named 'block': remove one");
}

TEST_F(BadInput, NamesASceneWithoutATable) {
  WriteFile(world_ / "scene.yaml", "objects: []\n");
  Expect(Run(), 2,
         "scene.yaml: the scene has no table; add 'table: {size: [1.2, 0.8], height: 0.75}'");
}

TEST_F(BadInput, NamesAReportFolderThatCannotBeMade) {
  WriteFile(world_ / "file", "");
  const std::string report = (world_ / "file" / "report").string();
  Expect(Run({"--report", report}), 2, "folder " + report + ": cannot be made: Not a directory");
}

TEST_F(BadInput, NamesAReportThatTheDiskHasNoRoomFor) {
  const std::filesystem::path page = world_ / "report" / "report.html";
  std::filesystem::create_directories(page.parent_path());
  std::filesystem::create_symlink("/dev/full", page);
  Expect(Run({"--plan-only", "--report", page.parent_path().string()}), 2,
         "cannot be written: No space left on device");
}

TEST_F(BadInput, NamesTaskAndBudgetThatMakeNoSense) {
  Expect(Run({"--set", "task.confidence=1"}), 2,
         "the confidence for a class that is not wanted by name is 1; it must lie between 0 and 1");
  Expect(Run({"--set", "task.wanted.block=0"}), 2,
         "the confidence for 'block' is 0; it must lie between 0 and 1");
  Expect(Run({"--set", "task.budget.looks=-1"}), 2, "budget.looks = -1; it must not be negative");
  Expect(Run({"--set", "task.budget.seconds=-5"}), 2,
         "budget.seconds = -5; it must not be negative; 0 means no limit");
  Expect(Run({"--set", "task.budget.metres=-0.5"}), 2,
         "budget.metres = -0.5; it must not be negative; 0 means no limit");
  Expect(Run({"--set", "task.budget.seconds=.nan"}), 2,
         "'task.budget.seconds' must be a finite number");
  Expect(Run({"--set", "task.wanted.unicorn=0.9"}), 2,
         "task.wanted names 'unicorn', which is not in the object database; it holds block");
}

TEST_F(BadInput, NamesValuesThatNoMissionCanWorkWith) {
  Expect(Run({"--set", "threads=0"}), 2, "'threads' = 0; it must be at least 1");
  Expect(Run({"--set", "mission.looks.frame_tries=0"}), 2, "frame_tries = 0 must be at least 1");
  Expect(Run({"--set", "mission.looks.frame_timeout_s=-1"}), 2,
         "frame_timeout_s = -1 must be at least 0");
  Expect(Run({"--set", "mission.understanding.depth_stride=0"}), 2,
         "depth_stride = 0 must be at least 1");
  Expect(Run({"--set", "mission.understanding.footprint_cell_m=0"}), 2,
         "footprint_cell_m = 0 must be at least 0.001");
  Expect(Run({"--set", "mission.understanding.match_sigmas=0"}), 2,
         "match_sigmas = 0 must be at least 0.1");
  Expect(Run({"--set", "mission.understanding.moved_within_m=-1"}), 2,
         "moved_within_m = -1 must be at least 0");
  Expect(Run({"--set", "seed"}), 2, "--set seed: must be KEY=VALUE, e.g. --set seed=7");
}

TEST_F(BadInput, NamesARobotThatCannotMoveOrArm) {
  Expect(Run({"--set", "mission.looks.hidden_space.cell_m=0"}), 2, "cell_m = 0 must lie in");
  Expect(Run({"--set", "mission.understanding.segment.split.window_m=1"}), 2,
         "window_m = 1 must lie in 0.004 to 0.1");
  Expect(Run({"--set", "mission.looks.arm.collision.clearance_m=0.005"}), 2,
         "views.motion.step_m = 0.02 with collision.clearance_m = 0.005: between two tests the arm "
         "could pass through something");
  const std::string arm = "robot.arm={urdf: sim/robots/arm.urdf";
  Expect(Run({"--set", arm + ", home_deg: [0, 90, 0, 0, 0, 0, 0]}"}), 2,
         "arm 'arm': where it stands at the beginning it reaches 0.94 m from the base's axis");
}

TEST_F(BadInput, NamesACameraThatDeliversNoDepthNothingOrIsLost) {
  Expect(Run({"--set", "robot.camera_fault=nan"}), 3,
         "camera 'head': no usable depth in 3 frames in a row; check its projector and driver");
  Expect(Run({"--set", "robot.camera_fault=nothing"}), 3,
         "camera 'head': no frame in 3 tries of 1 s; check its cable and driver");
  Expect(Run({"--set", "robot.camera_fault=lost"}), 3, "camera 'head': the device is lost");
}

TEST_F(BadInput, NamesAnLcmUrlThatItCannotUse) {
  const std::string config = world_.config().string();
  Expect(RunProgram({"run", "--config", config, "--lcm-url", "tcpq://localhost"}), 2,
         "LCM URL 'tcpq://localhost': it must begin with udpm:// or memq://");
}

TEST_F(BadInput, EndsWithStatusTwoForAWrongCommandLine) {
  EXPECT_EQ(RunProgram({}).status, 2);
  EXPECT_EQ(RunProgram({"dance"}).status, 2);
  EXPECT_EQ(RunProgram({"run"}).status, 2);
  EXPECT_EQ(RunProgram({"segment", "--cloud", "a.pcd", "--colour", "red"}).status, 2);
  Expect(RunProgram({"experiment", "luck"}), 2, "there is no experiment 'luck'; known: missions");
  Expect(RunProgram({"experiment", "missions", "--shard", "3/2"}), 2,
         "--shard 3/2: must be i/n with 1 <= i <= n, e.g. 1/4");
  EXPECT_EQ(RunProgram({"--help"}).status, 0);
  EXPECT_EQ(RunProgram({"--version"}).status, 0);
}

}  // namespace
}  // namespace secondlook
