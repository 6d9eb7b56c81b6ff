#include "apps/run_config.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "lib/common/files.h"
#include "lib/common/yaml_reader.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::apps {
namespace {

namespace fs = std::filesystem;

TEST(ShippedConfigurations, AllLoadAndNameScenesAndModelsThatExist) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator("config")) {
    if (entry.path().extension() != ".yaml") continue;
    const RunConfig config = LoadRunConfig(entry.path(), {});
    EXPECT_TRUE(fs::is_directory(config.models)) << entry.path();
    if (const auto* sim = std::get_if<sim::SimConfig>(&config.robot)) {
      EXPECT_NO_THROW(sim::LoadScene(sim->scene).Validate()) << entry.path();
    }
    ++count;
  }
  EXPECT_GE(count, 1);
}

TEST(RunConfig, HasDefaultsThatAreValid) {
  const RunConfig config;
  EXPECT_NO_THROW(config.Validate());
  EXPECT_NO_THROW(config.task.Validate());
  EXPECT_NO_THROW(config.mission.looks.Validate());
  EXPECT_NO_THROW(config.mission.looks.cost_map.Validate());
  EXPECT_NO_THROW(config.mission.looks.views.Validate());
  EXPECT_NO_THROW(config.mission.looks.aspect_graph.Validate());
  EXPECT_NO_THROW(config.mission.understanding.Validate());
  EXPECT_NO_THROW(config.mission.understanding.registration.Validate());
  EXPECT_NO_THROW(config.mission.understanding.voxel_space.Validate());
}

TEST(RunConfig, ReadsBackFromWhatIsWrittenBesideAReport) {
  const TemporaryFolder folder;
  const RunConfig config = LoadRunConfig(
      "config/sim.yaml", {"seed=18446744073709551615", "task.wanted={mug: 0.99, book: 0.5}",
                          "task.budget.seconds=0.1", "mission.looks.plan_seconds=0.123456789",
                          "robot.noise.color_sigma=1.5", "robot.camera_fault=nan"});
  SaveRunConfig(config, folder / "report" / "config.yaml");
  RunConfig again = LoadRunConfig(folder / "report" / "config.yaml", {});
  EXPECT_TRUE(fs::equivalent(again.models, config.models));
  auto& sim = std::get<sim::SimConfig>(again.robot);
  const std::string& scene = std::get<sim::SimConfig>(config.robot).scene;
  EXPECT_TRUE(fs::equivalent(sim.scene, scene));
  sim.scene = scene;
  again.models = config.models;
  EXPECT_EQ(ToYaml(again), ToYaml(config)) << "beside the paths, nothing has changed";
  EXPECT_EQ(again.seed, 18446744073709551615U);
  EXPECT_EQ(again.task.wanted.at("mug"), 0.99);
  EXPECT_EQ(sim.noise.color_sigma, 1.5);
}

TEST(RunConfig, LayersTheFileOverTheDefaultsAndOverridesOverTheFile) {
  const TemporaryFolder folder;
  WriteFile(folder / "c.yaml",
            "robot: !Sim {scene: s.yaml}\nmodels: ../m\nseed: 5\ntask: {confidence: 0.8}\n");
  const RunConfig config = LoadRunConfig(folder / "c.yaml", {"seed=6", "seed=7", "models=here"});
  EXPECT_EQ(config.threads, 2);
  EXPECT_EQ(config.task.confidence, 0.8);
  EXPECT_EQ(config.seed, 7U);
  EXPECT_EQ(config.models, "here") << "relative to the working folder";
  EXPECT_EQ(std::get<sim::SimConfig>(config.robot).scene, (folder / "s.yaml").string());
}

TEST(RunConfig, NamesTheOverrideThatIsWrong) {
  EXPECT_THROWS(LoadRunConfig("config/sim.yaml", {"task.budgt.looks=3"}), ConfigError,
                "--set task.budgt.looks=3");
  EXPECT_THROWS(LoadRunConfig("config/sim.yaml", {"robot.camera_fault=dust"}), ConfigError,
                "'camera_fault' = 'dust' must be none, nan, nothing or lost");
}

}  // namespace
}  // namespace secondlook::apps
