// A recorded mission, replayed, decides the same; and says so when it doesn't.

#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/make_robot.h"
#include "apps/mission.h"
#include "apps/mission_log.h"
#include "apps/mission_message.h"
#include "apps/model_watch.h"
#include "apps/publisher.h"
#include "lib/common/files.h"
#include "lib/transport/channels.h"
#include "lib/transport/event_log.h"
#include "lib/transport/message.h"
#include "tests/support/program.h"
#include "tests/support/small_world.h"
#include "tests/support/temporary_folder.h"

#include "second_look/look_t.hpp"
#include "second_look/rec_mission_t.hpp"

namespace secondlook::apps {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramResult;
using testing::RunProgram;
using testing::SignalAfter;

namespace channel = transport::channel;

/// A mission of the simulated robot, recorded: of a small world with one look at hidden space, or
/// of another configuration.
class RecordedMission {
 public:
  explicit RecordedMission(const std::vector<std::string>& overrides = {},
                           const std::string& config = "", SignalAfter signal = {"", 0}) {
    std::vector<std::string> arguments{
        "run",      "--config", config.empty() ? world.config().string() : config, "--log", log(),
        "--report", report()};
    for (const std::string& override : overrides) {
      arguments.push_back("--set");
      arguments.push_back(override);
    }
    result = RunProgram(arguments, std::move(signal));
  }

  std::string log() const { return (folder / "mission.log").string(); }
  std::string report() const { return (folder / "report").string(); }
  std::string json() const { return ReadFile(report() + "/mission.json"); }

  /// Replays `file`, by default the whole recording, into the report "again".
  ProgramResult Replay(const std::string& file = "", bool follow = false) const {
    std::vector<std::string> arguments{"replay", "--log", file.empty() ? log() : file, "--report",
                                       (folder / "again").string()};
    if (follow) arguments.emplace_back("--follow");
    return RunProgram(arguments);
  }

  std::string replayed_json() const { return ReadFile(folder / "again" / "mission.json"); }

  /// A copy of the recording in which `change` has changed events. Returns its name.
  std::string Changed(const std::function<void(transport::LogEvent*)>& change) const {
    const std::string file = (folder / "changed.log").string();
    transport::EventLogReader reader(log());
    transport::EventLogWriter writer(file, 1'000'000'000);
    while (auto event = reader.Next()) {
      change(&*event);
      writer.Write(event->utime, event->channel, event->bytes);
    }
    return file;
  }

  testing::SmallWorld world;
  TemporaryFolder folder;
  ProgramResult result;
};

/// Lets `change` change the body of an event.
template <class T, class Change>
void ChangeBody(transport::LogEvent* event, const Change& change) {
  T body{};
  ASSERT_GT(body.decode(event->bytes.data(), 0, static_cast<int>(event->bytes.size())), 0);
  change(&body);
  event->bytes = transport::Encode(body);
}

/// The recording with other values in its configuration.
std::string WithConfig(const RecordedMission& mission, const std::string& from,
                       const std::string& to) {
  return mission.Changed([&](transport::LogEvent* event) {
    if (event->channel != channel::kRecMission) return;
    ChangeBody<second_look::rec_mission_t>(event, [&](second_look::rec_mission_t* body) {
      const std::size_t at = body->config.find(from);
      ASSERT_NE(at, std::string::npos) << body->config;
      body->config.replace(at, from.size(), to);
    });
  });
}

TEST(Replay, OfTheDefaultMissionIsTheSameByteForByte) {
  const RecordedMission mission({}, "config/sim.yaml");
  ASSERT_EQ(mission.result.status, 0) << mission.result.err;
  EXPECT_THAT(mission.result.out, HasSubstr("the recording lies in " + mission.log()));
  const ProgramResult replay = mission.Replay();
  EXPECT_EQ(replay.status, 0) << replay.err;
  EXPECT_THAT(replay.out, HasSubstr("the same decisions as in the recording"));
  EXPECT_THAT(replay.err, Not(HasSubstr("warning")));
  EXPECT_TRUE(mission.replayed_json() == mission.json());
}

TEST(Replay, OfAMissionOfTheArmIsTheSameByteForByte) {
  const testing::SmallWorld world;
  world.LookByArm();
  const RecordedMission mission({"threads=1"}, world.config().string());
  ASSERT_EQ(mission.result.status, 0) << mission.result.err;
  EXPECT_THAT(mission.result.err, HasSubstr("s by the arm"));
  const ProgramResult replay = mission.Replay(WithConfig(mission, "threads: 1", "threads: 2"));
  EXPECT_EQ(replay.status, 0) << replay.err;
  EXPECT_THAT(replay.out, HasSubstr("the same decisions as in the recording"));
  EXPECT_TRUE(mission.replayed_json() == mission.json());
  EXPECT_EQ(mission.Replay("", true).status, 0) << "along the recorded looks";
}

TEST(Replay, OfAMissionThatEndsUnsettledHasItsStatus) {
  const RecordedMission mission({"seed=3", "task.budget.looks=1"}, "config/sim.yaml");
  ASSERT_EQ(mission.result.status, 4) << mission.result.err;
  const ProgramResult replay = mission.Replay();
  EXPECT_EQ(replay.status, 4) << replay.err;
  EXPECT_TRUE(mission.replayed_json() == mission.json());
}

TEST(Replay, NeedsNeitherTheSceneNorTheSimulator) {
  const RecordedMission mission;
  ASSERT_EQ(mission.result.status, 0) << mission.result.err;
  std::filesystem::remove(mission.world / "scene.yaml");
  EXPECT_EQ(mission.Replay().status, 0);
  EXPECT_TRUE(mission.replayed_json() == mission.json());
}

TEST(Replay, OfAPlanMakesThePlanAgain) {
  const testing::SmallWorld world;
  const std::string log = (world / "plan.log").string();
  const ProgramResult plan =
      RunProgram({"run", "--config", world.config().string(), "--plan-only", "--log", log});
  ASSERT_EQ(plan.status, 0) << plan.err;
  const ProgramResult replay = RunProgram({"replay", "--log", log});
  EXPECT_EQ(replay.status, 0) << replay.err;
  EXPECT_THAT(replay.out, HasSubstr("the same decisions as in the recording"));
}

TEST(Replay, OfAStoppedMissionStopsAtTheSamePlace) {
  // The default mission goes on for seconds after its second look: the signal comes in time.
  const RecordedMission mission({}, "config/sim.yaml", {"look 2 (", SIGTERM});
  ASSERT_EQ(mission.result.status, 143) << mission.result.err;
  const ProgramResult replay = mission.Replay();
  EXPECT_EQ(replay.status, 143) << replay.err;
  EXPECT_TRUE(mission.replayed_json() == mission.json());
}

/// Records a mission that is told in its second step to take no further look.
void RecordWithATask(const testing::SmallWorld& world, const std::string& file) {
  MissionLog log(file, 1000.0);
  const RunConfig config = LoadRunConfig(world.config(), {});
  const auto database = world::ObjectDatabase::Load(config.models);
  ReadyRobot ready = MakeRobot(config.robot, config.seed);
  log.Begin(config, database, false, &ready);
  Publisher publisher({&log});
  Mission mission(
      config.mission, config.task, database, ready.calibration, config.seed, [] { return false; },
      &publisher, &ready.robot);
  const auto start = DescribeStart(config, database, ready.robot.clock->Now());
  publisher.Mission(start);
  EXPECT_EQ(mission.Step(), Progress::kMore);
  world::Task task = config.task;
  task.budget.looks = 0;
  mission.SetTask(task);
  log.Task(task);
  const Progress progress = mission.Step();
  EXPECT_EQ(progress, Progress::kBudgetSpent);
  publisher.Mission(DescribeEnd(start, mission.record(), progress, ready.robot.clock->Now()));
}

TEST(Replay, GivesTheMissionTheTaskThatCameIn) {
  const testing::SmallWorld world;
  const std::string file = (world / "mission.log").string();
  RecordWithATask(world, file);
  const ProgramResult replay = RunProgram({"replay", "--log", file});
  EXPECT_EQ(replay.status, 4) << replay.err;
  EXPECT_THAT(replay.out, HasSubstr("the same decisions as in the recording"));
  EXPECT_THAT(replay.out, HasSubstr("the budget of 0 looks is spent"));
}

/// Records a mission in whose second step the block that it sees is added to its database.
void RecordWithANewModel(const testing::SmallWorld& world, const std::string& file) {
  MissionLog log(file, 1000.0);
  const RunConfig config = LoadRunConfig(world.config(), {});
  auto database = world::ObjectDatabase::Load(config.models);
  ModelWatch watch(config.models, database);
  ReadyRobot ready = MakeRobot(config.robot, config.seed);
  log.Begin(config, database, false, &ready);
  Publisher publisher({&log});
  Mission mission(
      config.mission, config.task, database, ready.calibration, config.seed, [] { return false; },
      &publisher, &ready.robot);
  const auto start = DescribeStart(config, database, ready.robot.clock->Now());
  publisher.Mission(start);
  EXPECT_EQ(mission.Step(), Progress::kMore);
  world::AddModel(world / "mesh" / "mesh.obj", geometry::LengthUnit::kMetre, "block",
                  world.models());
  Progress progress = Progress::kMore;
  while (progress == Progress::kMore) {
    for (const world::ObjectModel& model : watch.Take()) {
      mission.Learn(model);
      log.NewModel(model);
      database.Add(model);
    }
    progress = mission.Step();
  }
  EXPECT_EQ(progress, Progress::kSettled);
  publisher.Mission(DescribeEnd(start, mission.record(), progress, ready.robot.clock->Now()));
  ASSERT_EQ(mission.belief().objects.size(), 1U);
  EXPECT_EQ(mission.belief().objects[0].state, world::ObjectState::kVerified)
      << mission.belief().objects[0].reason;
}

TEST(Replay, GivesTheMissionTheModelThatWasAddedMeanwhile) {
  const testing::SmallWorld world;
  const std::string file = (world / "mission.log").string();
  geometry::SaveObj(geometry::MakeBox({0.3, 0.05, 0.05}, {0.1, 0.8, 0.1}), world / "rod");
  world::AddModel(world / "rod" / "mesh.obj", geometry::LengthUnit::kMetre, "rod", world.models());
  world::RemoveModel("block", world.models());
  RecordWithANewModel(world, file);

  const ProgramResult replay = RunProgram({"replay", "--log", file});
  EXPECT_EQ(replay.status, 0) << replay.err;
  EXPECT_THAT(replay.out, HasSubstr("the same decisions as in the recording"));
  EXPECT_THAT(replay.err, Not(HasSubstr("warning")));

  world::RemoveModel("block", world.models());
  const ProgramResult without = RunProgram({"replay", "--log", file});
  EXPECT_EQ(without.status, 5) << without.err;
  EXPECT_THAT(without.err,
              HasSubstr("model 'block' of the recorded mission is no longer in the database"));
}

TEST(Replay, OfAMissionWhoseCameraFailedFailsAlike) {
  const RecordedMission mission({"robot.camera_fault=lost"});
  ASSERT_EQ(mission.result.status, 3) << mission.result.err;
  const ProgramResult replay = mission.Replay();
  EXPECT_EQ(replay.status, 3) << replay.err;
  EXPECT_THAT(replay.err, HasSubstr("camera 'head': the device is lost"));
  EXPECT_TRUE(mission.replayed_json() == mission.json());
}

TEST(Replay, CutOffGoesToTheEndOfTheRecordingAndSaysSo) {
  const RecordedMission mission;
  const std::string whole = ReadFile(mission.log());
  const std::string cut = (mission.folder / "cut.log").string();
  for (const double share : {0.01, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9}) {
    WriteFile(cut, whole.substr(0, static_cast<std::size_t>(share * whole.size())));
    const ProgramResult replay = mission.Replay(cut);
    EXPECT_EQ(replay.status, 4) << share << ": " << replay.err;
    EXPECT_THAT(replay.err, HasSubstr("cut.log: ends before the mission does"));
    EXPECT_THAT(replay.err, HasSubstr("the recording ends here"));
    EXPECT_THAT(replay.out, HasSubstr("the same decisions as in the recording"));
  }
}

TEST(Replay, OfWhatIsNoRecordingIsRefused) {
  const RecordedMission mission({"robot.camera_fault=lost"});
  const std::string cut = (mission.folder / "cut.log").string();
  WriteFile(cut, ReadFile(mission.log()).substr(0, 100));
  for (const std::string& file : {cut, mission.world.config().string()}) {
    const ProgramResult replay = mission.Replay(file);
    EXPECT_EQ(replay.status, 2);
    EXPECT_THAT(replay.err, HasSubstr("is no recording of a mission"));
  }
}

TEST(Replay, OfADamagedRecordingNeverCrashes) {
  const RecordedMission mission;
  const std::string whole = ReadFile(mission.log());
  std::mt19937 random(3);
  for (int trial = 0; trial < 8; ++trial) {
    std::string damaged = whole;
    for (int i = 0; i < 40; ++i) damaged[random() % whole.size()] ^= static_cast<char>(random());
    WriteFile(mission.folder / "damaged.log", damaged);
    const ProgramResult replay = mission.Replay((mission.folder / "damaged.log").string());
    EXPECT_THAT(replay.status, AnyOf(0, 2, 3, 4, 5)) << replay.err;
  }
}

TEST(Replay, NamesADamagedFrame) {
  const RecordedMission mission;
  const std::string changed = mission.Changed([](transport::LogEvent* event) {
    if (event->channel == channel::kRecImage) event->bytes[event->bytes.size() / 2] ^= 0x55;
  });
  const ProgramResult replay = mission.Replay(changed);
  EXPECT_EQ(replay.status, 3);
  EXPECT_THAT(replay.err, HasSubstr("the colour of recorded frame "));
}

TEST(Replay, NamesTheFirstDecisionThatDiffers) {
  const RecordedMission mission;
  const std::string changed = mission.Changed([](transport::LogEvent* event) {
    if (event->channel != channel::kLook) return;
    ChangeBody<second_look::look_t>(event, [](second_look::look_t* look) {
      if (look->step == 2) look->target = 99;
    });
  });
  const ProgramResult replay = mission.Replay(changed);
  EXPECT_EQ(replay.status, 5);
  EXPECT_THAT(replay.err, HasSubstr("another decision than in the recording: step 2, "
                                    "SECONDLOOK_LOOK, 'target': recorded 99, now -1"));
}

TEST(Replay, NamesADecisionThatIsNoLongerTaken) {
  const RecordedMission mission;
  const ProgramResult replay = mission.Replay(WithConfig(mission, "looks: 20", "looks: 0"));
  EXPECT_EQ(replay.status, 5);
  EXPECT_THAT(replay.err,
              HasSubstr("another decision than in the recording: step 2, "
                        "SECONDLOOK_CANDIDATES: recorded a message, now nothing, but the end: the "
                        "budget of 0 looks is spent"));
}

TEST(Replay, FollowsTheRecordedLooksAndListsWhatDiffers) {
  const RecordedMission mission;
  const ProgramResult replay = mission.Replay(WithConfig(mission, "looks: 20", "looks: 0"), true);
  EXPECT_EQ(replay.status, 5) << replay.err;
  EXPECT_THAT(replay.out, HasSubstr("differences from the recording:\nstep 2, SECONDLOOK_LOOK: "
                                    "recorded \"sees "));
  EXPECT_THAT(replay.out, HasSubstr(", now no look, but the end: the budget of 0 looks is spent"));
  const auto objects = [](const std::string& text) {
    return nlohmann::json::parse(text)["objects"];
  };
  EXPECT_EQ(objects(mission.replayed_json()), objects(mission.json())) << "it saw the same views";
}

TEST(Replay, FollowingChangesNothingWhereTheDecisionsAreTheSame) {
  const RecordedMission mission;
  const ProgramResult replay = mission.Replay("", true);
  EXPECT_EQ(replay.status, 0) << replay.err;
  EXPECT_TRUE(mission.replayed_json() == mission.json());
}

TEST(Replay, SaysBeforehandWhichModelsHaveChanged) {
  const RecordedMission mission;
  const std::string models = mission.world.models().string();
  RunProgram({"model", "remove", "--name", "block", "--models", models});
  geometry::SaveObj(geometry::MakeBox({0.1, 0.15, 0.21}, {0.8, 0.1, 0.1}), mission.folder / "new");
  RunProgram({"model", "add", "--mesh", (mission.folder / "new" / "mesh.obj").string(), "--unit",
              "m", "--name", "block", "--models", models});
  EXPECT_THAT(mission.Replay().err,
              HasSubstr("model 'block' has changed since the recording: its hash was "));
}

TEST(Recording, OfASimulatedMissionDependsOnTheMissionAlone) {
  const auto events = [](const std::string& threads) {
    const RecordedMission mission({"threads=" + threads});
    std::vector<std::pair<std::string, std::vector<std::uint8_t>>> all;
    transport::EventLogReader reader(mission.log());
    while (const auto event = reader.Next()) {
      // One says how long it took, the others where the models lie.
      if (event->channel == channel::kTiming || event->channel == channel::kRecMission ||
          event->channel == channel::kMission) {
        continue;
      }
      all.emplace_back(event->channel + std::to_string(event->utime), event->bytes);
    }
    return all;
  };
  EXPECT_TRUE(events("1") == events("2"));
}

TEST(Recording, HoldsNoMessageThatIsTooLongForTheBus) {
  const RecordedMission mission;
  transport::EventLogReader reader(mission.log());
  while (const auto event = reader.Next()) {
    EXPECT_LE(event->bytes.size(), transport::kMaxMessageBytes) << event->channel;
  }
}

TEST(Recording, InSeveralPartsIsReplayedAsOne) {
  const testing::SmallWorld world;
  const std::string log = (world / "mission.log").string();
  const ProgramResult run =
      RunProgram({"run", "--config", world.config().string(), "--log", log, "--log-split-mb", "1"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(std::filesystem::exists(log + ".01"));
  EXPECT_EQ(RunProgram({"replay", "--log", log}).status, 0);
  std::filesystem::remove(log + ".01");
  EXPECT_THAT(RunProgram({"replay", "--log", log}).err, HasSubstr("the recording ends here"));
}

TEST(Recording, ThatCannotBeWrittenIsToldBeforeTheMissionStarts) {
  const testing::SmallWorld world;
  const ProgramResult result = RunProgram(
      {"run", "--config", world.config().string(), "--log", "/proc/nowhere/mission.log"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, HasSubstr("/proc/nowhere/mission.log: cannot be written"));
  EXPECT_THAT(result.err, Not(HasSubstr("look 1")));
}

TEST(Recording, OnAFullDiskEndsAndTheMissionGoesOn) {
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  rlimit small = limit;
  small.rlim_cur = 1'000'000;  // as good as a disk with that much left
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const RecordedMission mission;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  EXPECT_EQ(mission.result.status, 0) << mission.result.err;
  EXPECT_THAT(mission.result.err, HasSubstr("the recording ends here, the mission goes on"));
  EXPECT_THAT(mission.result.out,
              HasSubstr("is not whole: " + mission.log() + ": cannot be written: File too large"));
  EXPECT_THAT(mission.json(), HasSubstr("everything is settled"));
  // What was recorded until then is whole.
  EXPECT_LE(std::filesystem::file_size(mission.log()), 1'000'000U);
  const ProgramResult replay = mission.Replay();
  EXPECT_EQ(replay.status, 4) << replay.err;
  EXPECT_THAT(replay.err, HasSubstr("the recording ends here"));
  EXPECT_THAT(replay.err, Not(HasSubstr("cut off")));
}

/// The exit status of a shell command; its output is not shown.
int Shell(const std::string& command) {
  return WEXITSTATUS(std::system(("{ " + command + "; } >/dev/null 2>&1").c_str()));
}

TEST(Recording, OpensWithPythonsLcm) {
  if (Shell("tools/python_lcm") != 0) GTEST_SKIP() << "no Python package lcm";
  const RecordedMission mission;
  int events = 0;
  transport::EventLogReader reader(mission.log());
  while (reader.Next()) ++events;
  EXPECT_EQ(
      Shell("$(tools/python_lcm) -c 'import lcm, sys; names = [e.channel for e in lcm.EventLog(\"" +
            mission.log() + "\", \"r\")]; sys.exit(names[0] != \"REC_MISSION\" or " +
            "len(names) != " + std::to_string(events) + ")'"),
      0);
}

TEST(Recording, PlaysWithLcmLogplayer) {
  const std::string network =
      "unshare -n sh -c 'ip link set lo up && ip route add 224.0.0.0/4 "
      "dev lo && ";
  if (Shell("lcm-logplayer --help; test $? -le 1 && " + network + "true'") != 0) {
    GTEST_SKIP() << "no lcm-logplayer, or no network namespaces";
  }
  const RecordedMission mission({"task.budget.looks=0"});
  EXPECT_EQ(
      Shell(network + "lcm-logplayer --speed=1000 --lcm-url=udpm://239.255.76.67:7667?ttl=0 " +
            mission.log() + "'"),
      0);
}

}  // namespace
}  // namespace secondlook::apps
