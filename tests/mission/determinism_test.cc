// The same seed gives the same mission byte for byte, for any number of threads.

#include <csignal>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "lib/common/files.h"
#include "tests/mission/simulated_mission.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::apps {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::RunProgram;

/// Enough of a mission to drive, register, fuse and choose again.
const std::string kTwoLooks = "task.budget.looks=2";

/// The mission.json of a process of its own.
std::string ProgramJson(const TemporaryFolder& folder, const std::string& config,
                        const std::string& threads) {
  const std::string report = (folder / ("report_" + threads)).string();
  const ProgramResult result =
      RunProgram({"run", "--config", config, "--lcm-url", "none", "--report", report, "--set",
                  "threads=" + threads, "--set", kTwoLooks});
  EXPECT_THAT(result.status, AnyOf(0, 4)) << result.err;
  EXPECT_THAT(result.out, HasSubstr("the result lies in " + report));
  EXPECT_TRUE(std::filesystem::exists(report + "/view_0.png"));
  EXPECT_TRUE(std::filesystem::exists(report + "/config.yaml"));
  return ReadFile(report + "/mission.json");
}

TEST(Determinism, TwoMissionsInOneProcessEqualTwoProcessesWithOneAndTwoThreads) {
  const TemporaryFolder folder;
  const std::string one_thread = ProgramJson(folder, "config/sim.yaml", "1");
  // The effective configuration in the report of the first gives the same mission again.
  const std::string saved = (folder / "report_1" / "config.yaml").string();
  const std::string two_threads = ProgramJson(folder, saved, "2");
  EXPECT_TRUE(one_thread == two_threads) << "the number of threads matters";
  const std::string first = SimulatedMission({"threads=2", kTwoLooks}).Json();
  const std::string second = SimulatedMission({"threads=1", kTwoLooks}).Json();
  EXPECT_TRUE(first == two_threads) << "a test's process and the program's differ";
  EXPECT_TRUE(second == first) << "the second mission of a process differs from its first";
}

TEST(Determinism, AnotherSeedGivesAnotherMission) {
  // One view is enough: localisation, camera and head err by the seed.
  const auto objects = [](const std::string& seed) {
    const SimulatedMission run({"task.budget.looks=0", "seed=" + seed});
    return nlohmann::json::parse(run.Json())["objects"].dump();
  };
  const std::string one = objects("1");
  EXPECT_TRUE(one == objects("1"));
  EXPECT_FALSE(one == objects("2"));
}

TEST(StopSignal, InTheMidstOfAMissionFinishesTheFiles) {
  const TemporaryFolder folder;
  const std::string report = (folder / "report").string();
  const ProgramResult result =
      RunProgram({"run", "--config", "config/sim.yaml", "--lcm-url", "none", "--report", report},
                 {"look 2 (", SIGTERM});
  EXPECT_EQ(result.status, 143) << result.err;
  const auto mission = nlohmann::json::parse(ReadFile(report + "/mission.json"));
  EXPECT_EQ(mission["end"], "stopped on request");
  EXPECT_GE(mission["objects"].size(), 5U);
  EXPECT_GE(mission["looks"].size(), 2U);
  EXPECT_TRUE(std::filesystem::exists(report + "/view_0.png"));
}

TEST(Budget, ThatIsSpentEndsWithStatusFour) {
  const TemporaryFolder folder;
  const std::string report = (folder / "report").string();
  const ProgramResult result =
      RunProgram({"run", "--config", "config/sim.yaml", "--lcm-url", "none", "--report", report,
                  "--set", "task.budget.looks=0"});
  EXPECT_EQ(result.status, 4) << result.err;
  const auto mission = nlohmann::json::parse(ReadFile(report + "/mission.json"));
  EXPECT_EQ(mission["end"], "the budget of 0 looks is spent");
  EXPECT_EQ(mission["metres"], 0.0);
}

}  // namespace
}  // namespace secondlook::apps
