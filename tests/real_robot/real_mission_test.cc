// The default mission with the drivers of real devices, all at once, each speaking with an emulator
// that the simulated world feeds. It takes as long as such a mission takes, minutes, so it runs
// only where SECONDLOOK_WALL_TIME says how many.

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "apps/experiments/judge.h"
#include "apps/mission.h"
#include "apps/publisher.h"
#include "apps/run_config.h"
#include "lib/common/parallel.h"
#include "lib/world/object_database.h"
#include "tests/real_robot/emulated_robot.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::apps {
namespace {

/// What became of a mission.
struct Outcome {
  Progress progress{};
  std::vector<Verdict> verdicts;
};

Outcome RunWithRealDrivers(std::uint64_t seed) {
  const RunConfig config = LoadRunConfig("config/sim.yaml", {"seed=" + std::to_string(seed)});
  const auto& sim_config = std::get<sim::SimConfig>(config.robot);
  const ThreadLimit threads(1);  // the world draws on the other processor
  const auto database = world::ObjectDatabase::Load(config.models);
  const TemporaryFolder folder;
  const auto link = std::make_shared<hal::LcmLink>("memq://");
  EmulatedRobot emulated(
      sim::MakeSimulatedRobot(sim::LoadScene(sim_config.scene), sim_config, seed), link,
      folder.path(), 0.3);
  hal::Robot robot;
  robot.clock = std::make_unique<hal::LiveClock>();
  RealDevices devices(emulated.Config("memq://"), robot.clock.get(), link);
  robot.head_camera = std::make_unique<JudgedCamera>(devices.OpenCamera(), &emulated);
  robot.base = devices.OpenBase();
  robot.head = devices.OpenHead();
  Publisher publisher(std::vector<transport::Sink*>{});
  Mission mission(
      config.mission, config.task, database, emulated.calibration(), config.seed,
      [] { return false; }, &publisher, &robot);
  Outcome outcome;
  for (int i = 0; i < 100 && outcome.progress == Progress::kMore; ++i) {
    outcome.progress = mission.Step();
  }
  emulated.End();
  outcome.verdicts = Judge(mission, emulated.world(), {.max_m = 0.005, .max_deg = 2.0});
  return outcome;
}

TEST(RealRobot, FindsInWallTimeWhatItFindsInSimulation) {
  const char* count = std::getenv("SECONDLOOK_WALL_TIME");
  if (count == nullptr) GTEST_SKIP() << "SECONDLOOK_WALL_TIME=N runs N missions, minutes each";
  const int missions = std::atoi(count);
  int same = 0;
  for (int seed = 1; seed <= missions; ++seed) {
    const Outcome outcome = RunWithRealDrivers(static_cast<std::uint64_t>(seed));
    int right = 0;
    int unknown = 0;
    for (const Verdict& v : outcome.verdicts) {
      right += v.kind == Verdict::Kind::kRight ? 1 : 0;
      unknown += v.kind == Verdict::Kind::kUnknownRight ? 1 : 0;
      fmt::print("seed {}: {} is called '{}': {}, {:.1f} mm and {:.2f} deg off\n", seed, v.truth,
                 v.belief, ToString(v.kind), 1e3 * v.error_m, v.error_deg);
    }
    const bool all = outcome.progress == Progress::kSettled && outcome.verdicts.size() == 7U &&
                     right == 6 && unknown == 1;
    same += all ? 1 : 0;
    fmt::print("seed {}: {}\n", seed, all ? "as in simulation" : "otherwise");
  }
  EXPECT_GE(same, 0.9 * missions);
}

}  // namespace
}  // namespace secondlook::apps
