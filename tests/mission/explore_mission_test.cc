// Missions that model what they do not know.

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/files.h"
#include "lib/geometry/mesh.h"
#include "lib/world/object_database.h"
#include "tests/support/program.h"
#include "tests/support/small_world.h"

namespace secondlook::apps {
namespace {

using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::RunProgram;

/// A small world with a duck, which nobody knows.
class ExploreMission : public ::testing::Test {
 protected:
  ExploreMission() {
    WriteScene("");
    WriteFile(world_.config(),
              "robot: !Sim\n  scene: scene.yaml\nmodels: models\nlearned: learned\nmission:\n"
              "  looks: {at_hidden_space: 0}\n"
              "  modelling: {coverage: 0.8, worthwhile: 0.02, scans: 6}\n");
  }

  /// `more`: lines of other objects.
  void WriteScene(const std::string& more) const {
    const std::string duck = std::filesystem::absolute("sim/unfamiliar/duck/mesh.obj").string();
    WriteFile(world_ / "scene.yaml",
              "table: {size: [0.6, 0.6], height: 0.75}\nobjects:\n  - {mesh: " + duck +
                  ", unit: m, name: duck, role: unknown, position: [0, 0]}\n" + more +
                  "robot: {position: [-1.4, 0.0]}\n");
  }

  std::string learned() const { return (world_ / "learned").string(); }

  ProgramResult Run(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"run", "--config", world_.config().string(), "--lcm-url",
                                       "none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  testing::SmallWorld world_;
};

TEST_F(ExploreMission, ModelsAThingThatKnowsNobodyAndRecognisesItFromThenOn) {
  const std::string log = (world_ / "mission.log").string();
  const ProgramResult first = Run({"--log", log, "--report", (world_ / "first").string()});
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("modelled as 'object_1' from"));
  const auto database = world::ObjectDatabase::Load(learned());
  const world::ObjectModel* model = database.Find("object_1");
  ASSERT_NE(model, nullptr);
  ASSERT_TRUE(model->provenance);
  EXPECT_EQ(model->provenance->sensor, "depth camera");
  EXPECT_GE(model->provenance->scans, 2);
  EXPECT_GT(model->provenance->coverage, 0.5);
  EXPECT_GT(world::ReadFullMesh(model->folder).triangles.size(), model->mesh.triangles.size());

  // The recording has what the cameras saw, so the model is made anew, the same to the last bit,
  // whatever lies on disk by now.
  const ProgramResult replay =
      RunProgram({"replay", "--log", log, "--report", (world_ / "replay").string()});
  EXPECT_EQ(replay.status, 0) << replay.err;
  EXPECT_TRUE(ReadFile(world_ / "first" / "mission.json") ==
              ReadFile(world_ / "replay" / "mission.json"));

  const ProgramResult second = Run({"--report", (world_ / "second").string()});
  EXPECT_EQ(second.status, 0) << second.err;
  EXPECT_THAT(second.out, HasSubstr("verified   object_1"));
  EXPECT_THAT(second.out, ::testing::Not(HasSubstr("modelled as")));
  EXPECT_EQ(world::ObjectDatabase::Load(learned()).models().size(), 1U);
}

TEST_F(ExploreMission, ModelsWhatItDoesNotKnowAlthoughNoLookCanHelpWhatIsOpen) {
  geometry::SaveObj(geometry::MakeBox({0.03, 0.03, 0.03}, {0.1, 0.2, 0.8}), world_ / "cube");
  WriteScene(
      "  - {mesh: cube/mesh.obj, unit: m, name: cube, role: unknown, position: [0, 0.24]}\n");
  // One view tells that a thing is unknown; the cube is too small for that, and stays open: no
  // look at it is worth its time.
  const ProgramResult result = Run({"--set", "mission.understanding.conclude.unknown_views=1",
                                    "--set", "mission.looks.aspect_graph.loss.per_second=100"});
  EXPECT_THAT(result.err, HasSubstr("look 2 (scan)"));
  EXPECT_THAT(result.out, HasSubstr("modelled as 'object_1' from"));
}

TEST_F(ExploreMission, MakesNoModelOfWhatAStopInterrupts) {
  const ProgramResult result = RunProgram(
      {"run", "--config", world_.config().string(), "--lcm-url", "none"}, {"(scan)", SIGTERM});
  EXPECT_EQ(result.status, 143) << result.err;
  EXPECT_THAT(result.out, ::testing::Not(HasSubstr("modelled as")));
  EXPECT_FALSE(std::filesystem::exists(learned())) << "nothing half-made";
}

TEST_F(ExploreMission, KnowsAModelInThisMissionAloneThatCannotBeKept) {
  WriteFile(world_ / "learned", "a file where the folder should be");
  const ProgramResult result = Run({});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("model 'object_1' is known in this mission alone: "));
  EXPECT_THAT(result.out, HasSubstr("verified   object_1"));
}

}  // namespace
}  // namespace secondlook::apps
