// What a robot answered while it was recorded, it answers again.

#include "lib/hal/replay/playback.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/files.h"
#include "lib/hal/replay/recorder.h"
#include "lib/hal/tap.h"
#include "lib/transport/channels.h"
#include "lib/transport/log_sink.h"
#include "tests/hal/camera_contract.h"
#include "tests/hal/clock_contract.h"
#include "tests/sim/rig.h"
#include "tests/support/expect_throws.h"
#include "tests/support/fake_robot.h"
#include "tests/support/temporary_folder.h"

#include "second_look/look_t.hpp"
#include "second_look/mission_t.hpp"

namespace secondlook::hal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

second_look::mission_t EndOfMission() {
  second_look::mission_t mission{};
  mission.end = "done";
  return mission;
}

/// A fake robot that is recorded to a file, and the file.
class RecordedFake {
 public:
  RecordedFake() {
    Robot fake = testing::MakeFakeRobot(&world);
    second_look::rec_mission_t mission{};
    mission.config = "seed: 4";
    calibration.X_HC.translation() = Eigen::Vector3d(0.1, 0.2, 0.3);
    Describe(fake, calibration, std::nullopt, &mission);
    recorder.Begin(mission);
    robot = Tap(std::move(fake), &recorder);
  }

  void SetOut() { log.Post(transport::Pack(transport::channel::kLook, second_look::look_t{})); }

  Recording EndWhole() {
    log.Post(transport::Pack(transport::channel::kMission, EndOfMission()));
    return EndEarly();
  }

  Recording EndEarly() {
    log.Close();
    return Recording::Load(folder / "log");
  }

  TemporaryFolder folder;
  testing::FakeWorld world;
  kinematics::HeadCalibration calibration;
  transport::LogSink log{folder / "log", 1'000'000'000};
  Recorder recorder{&log};
  Robot robot;
};

TEST(Recording, KeepsWhatTheRobotIs) {
  RecordedFake recorded;
  const Recording recording = recorded.EndWhole();
  EXPECT_EQ(recording.start.config, "seed: 4");
  EXPECT_EQ(recording.robot.base.name, "wheels");
  EXPECT_EQ(recording.robot.base.turn_rate, 1.0);
  EXPECT_EQ(recording.robot.head.name, "neck");
  EXPECT_EQ(recording.robot.head.upper, (PanTiltAngles{2.0, 1.0}));
  EXPECT_EQ(recording.robot.head_camera.name, "eye");
  EXPECT_TRUE(recording.robot.head_camera.model == recorded.robot.head_camera->info().model);
  EXPECT_EQ(recording.robot.head_camera.max_depth, 6.0);
  EXPECT_TRUE(recording.robot.calibration.X_HC.matrix() == recorded.calibration.X_HC.matrix());
  EXPECT_TRUE(recording.complete);
  EXPECT_TRUE(recording.warnings.empty());
}

TEST(Playback, ClockStatesAndMotionsAreAnsweredAgain) {
  RecordedFake recorded;
  recorded.world.base_takes = Seconds(1);
  recorded.world.base_speed = 0.123456789;
  recorded.world.base_ends = {MotionPhase::kFailed, "blocked"};
  const auto visit = [](Robot& robot) {
    std::vector<std::string> seen;
    const auto note = [&] {
      const BaseState base = robot.base->State();
      const MotionStatus status = robot.base->Status();
      seen.push_back(fmt::format("{} {} {} {} {} {}", robot.clock->Now().time_since_epoch().count(),
                                 base.time.time_since_epoch().count(), base.X_WB.x,
                                 robot.head->State().angles.pan, static_cast<int>(status.phase),
                                 status.reason));
    };
    note();
    robot.base->Start({{{1.0, 0.0, 0.0}}});
    robot.clock->SleepUntil(robot.clock->Now() + Seconds(0.7));
    note();
    robot.clock->ChargeThinking(Seconds(0.7));
    robot.head->Start({0.5, 0.1});
    robot.clock->SleepUntil(robot.clock->Now() + Seconds(1.0 / 3.0));
    robot.head->Status();
    note();
    return seen;
  };
  const std::vector<std::string> then = visit(recorded.robot);
  const Recording recording = recorded.EndWhole();
  Playback playback(recording);
  Robot robot = playback.MakeRobot();
  EXPECT_EQ(visit(robot), then);
  EXPECT_THAT(then.back(), HasSubstr("3 blocked"));
}

/// What the arm and the camera in its hand answer, a motion in between.
std::vector<std::string> VisitArm(Robot& robot) {
  std::vector<std::string> seen;
  const auto note = [&] {
    const ArmState arm = robot.arm->State();
    const auto frame = robot.hand_camera->Grab(Seconds(1));
    seen.push_back(
        fmt::format("{} {} {} {} {}", arm.time.time_since_epoch().count(), arm.q[0],
                    static_cast<int>(robot.arm->Status().phase), frame ? frame->sequence : 0,
                    frame ? static_cast<int>(frame->color.at<cv::Vec3b>(200, 300)[1]) : 0));
  };
  note();
  const Eigen::VectorXd from = robot.arm->State().q;
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(from.size());
  Eigen::VectorXd to = from;
  to[0] += 0.1;
  robot.arm->Start({{{0.0, from, rest}, {1.0, to, rest}}});
  note();
  robot.clock->SleepUntil(robot.clock->Now() + Seconds(2));
  note();
  return seen;
}

/// Such a visit to the simulated robot.
Recording RecordArm(std::vector<std::string>* seen) {
  const TemporaryFolder folder;
  sim::SimConfig config;
  config.arm.emplace().urdf = "sim/robots/arm.urdf";
  sim::SimulatedRobot simulated = sim::MakeSimulatedRobot(sim::FreeScene(), config, 3);
  transport::LogSink log(folder / "log", 1'000'000'000);
  Recorder recorder(&log);
  second_look::rec_mission_t mission{};
  Describe(simulated.robot, simulated.calibration, simulated.hand, &mission);
  recorder.Begin(mission);
  {
    Robot tapped = Tap(std::move(simulated.robot), &recorder);
    *seen = VisitArm(tapped);
  }
  log.Post(transport::Pack(transport::channel::kMission, EndOfMission()));
  log.Close();
  return Recording::Load(folder / "log");
}

TEST(Playback, TheArmAndItsCameraAnswerAgain) {
  std::vector<std::string> then;
  const Recording recording = RecordArm(&then);
  ASSERT_TRUE(recording.robot.arm);
  const ArmDescription& arm = *recording.robot.arm;
  EXPECT_EQ(arm.arm.name, "arm");
  EXPECT_EQ(arm.arm.joints.size(), 7U);
  EXPECT_EQ(arm.camera.name, "hand");
  Playback playback(recording);
  Robot robot = playback.MakeRobot();
  EXPECT_EQ(VisitArm(robot), then);
  EXPECT_EQ(then.size(), 3U);
  // The description gives the same kinematics.
  const Eigen::VectorXd q = Eigen::VectorXd::Constant(7, 0.3);
  const kinematics::Chain chain(kinematics::LoadUrdf("sim/robots/arm.urdf"), "flange");
  EXPECT_TRUE(arm.hand.arm.TipPose(q).isApprox(chain.TipPose(q), 0.0));
}

TEST(Playback, FramesComeAgainAndSoDoesThatNoneCame) {
  RecordedFake recorded;
  recorded.world.now = Time(Seconds(5));
  RgbdFrame frame{Time(Seconds(4.9)), 12, cv::Mat(48, 64, CV_8UC3, cv::Scalar(1, 2, 3)),
                  cv::Mat(48, 64, CV_32FC1, cv::Scalar(1.25))};
  recorded.world.frames.push_back(frame);
  recorded.robot.head_camera->Grab(Seconds(1));
  recorded.robot.head_camera->Grab(Seconds(1));
  const Recording recording = recorded.EndWhole();
  Playback playback(recording);
  Robot robot = playback.MakeRobot();
  const auto again = robot.head_camera->Grab(Seconds(1));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->time, frame.time);
  EXPECT_EQ(again->sequence, 12U);
  EXPECT_EQ(again->color.at<cv::Vec3b>(47, 63), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(again->depth.at<float>(47, 63), 1.25F);
  EXPECT_EQ(robot.clock->Now(), Time(Seconds(5)));
  EXPECT_FALSE(robot.head_camera->Grab(Seconds(1)));
  EXPECT_EQ(robot.clock->Now(), Time(Seconds(6)));
}

TEST(Playback, ErrorsAreThrownAgain) {
  RecordedFake recorded;
  recorded.world.base_lost_on_status = true;
  recorded.world.head_lost_on_start = true;
  EXPECT_THROW(recorded.robot.base->Status(), DeviceError);
  EXPECT_THROW(recorded.robot.head->Start({}), DeviceError);
  const Recording recording = recorded.EndWhole();
  Playback playback(recording);
  Robot robot = playback.MakeRobot();
  EXPECT_THROWS(robot.base->Status(), DeviceError, "base 'wheels': the device is lost");
  EXPECT_THROWS(robot.head->Start({}), DeviceError, "pan-tilt 'neck': the device is lost");
}

TEST(Playback, EachLookBringsTheAnswersThatCameAfterIt) {
  RecordedFake recorded;
  for (const double x : {1.0, 2.0, 3.0}) {
    recorded.world.X_WB.x = x;
    recorded.robot.base->State();
    recorded.robot.base->State();
    if (x < 3.0) recorded.SetOut();
  }
  const Recording recording = recorded.EndWhole();
  ASSERT_EQ(recording.segments.size(), 3U);
  Playback playback(recording);
  Robot robot = playback.MakeRobot();
  const auto x = [&] { return robot.base->State().X_WB.x; };
  EXPECT_EQ(x(), 1.0);
  playback.NextLook();  // asked less often than it was
  EXPECT_EQ(x(), 2.0);
  EXPECT_EQ(x(), 2.0);
  EXPECT_EQ(x(), 2.0);  // more often
  playback.NextLook();
  EXPECT_EQ(x(), 3.0);
}

TEST(Playback, AskedForMoreThanWasRecordedTimeGoesOnAndNoFrameComes) {
  RecordedFake recorded;
  recorded.robot.base->Status();
  const Recording recording = recorded.EndWhole();
  Playback playback(recording);
  Robot robot = playback.MakeRobot();
  robot.clock->SleepUntil(Time(Seconds(3)));
  robot.clock->ChargeThinking(Seconds(1));
  EXPECT_EQ(robot.clock->Now(), Time(Seconds(4)));
  EXPECT_FALSE(robot.head_camera->Grab(Seconds(2)));
  EXPECT_EQ(robot.clock->Now(), Time(Seconds(6)));
  EXPECT_EQ(robot.base->Status().phase, MotionPhase::kIdle);
  EXPECT_EQ(robot.base->Status().phase, MotionPhase::kIdle);
}

TEST(Playback, OfARecordingThatEndsEarlyEndsThere) {
  RecordedFake recorded;
  recorded.robot.head_camera->Grab(Seconds(1));
  const Recording recording = recorded.EndEarly();
  EXPECT_FALSE(recording.complete);
  EXPECT_THAT(recording.warnings, ElementsAre(HasSubstr("ends before the mission does")));
  Playback playback(recording);
  Robot robot = playback.MakeRobot();
  EXPECT_FALSE(robot.head_camera->Grab(Seconds(1)));
  EXPECT_THROWS(robot.head_camera->Grab(Seconds(1)), EndOfRecording,
                "the recording ends here, after look 0: it has nothing more of camera 'eye'");
  EXPECT_THROWS(robot.base->State(), EndOfRecording, "base 'wheels'");
}

TEST(Playback, StopsWhereTheRecordedMissionWasStopped) {
  RecordedFake recorded;
  recorded.SetOut();
  recorded.robot.clock->SleepUntil(Time(Seconds(1)));
  recorded.recorder.StopAsked(false, 0);
  recorded.recorder.StopAsked(false, 0);
  recorded.recorder.StopAsked(true, 15);
  recorded.robot.clock->SleepUntil(Time(Seconds(2)));
  recorded.recorder.StopAsked(true, 15);
  const Recording recording = recorded.EndWhole();
  Playback playback(recording);
  Robot robot = playback.MakeRobot();
  EXPECT_EQ(playback.stop_signal(), 15);
  playback.NextLook();
  robot.clock->SleepUntil(Time(Seconds(1)));
  EXPECT_FALSE(playback.AskStop());
  EXPECT_FALSE(playback.AskStop());
  EXPECT_TRUE(playback.AskStop());
}

TEST(Playback, StopsAMissionThatAsksLessOftenOnceItsTimeIsPast) {
  RecordedFake recorded;
  for (int i = 0; i < 9; ++i) recorded.recorder.StopAsked(false, 0);
  recorded.robot.clock->SleepUntil(Time(Seconds(1)));
  recorded.recorder.StopAsked(true, 0);
  recorded.robot.clock->SleepUntil(Time(Seconds(2)));
  const Recording recording = recorded.EndWhole();
  Playback playback(recording);
  Robot robot = playback.MakeRobot();
  robot.clock->SleepUntil(Time(Seconds(1)));
  EXPECT_FALSE(playback.AskStop());
  robot.clock->SleepUntil(Time(Seconds(2)));
  EXPECT_TRUE(playback.AskStop());
}

TEST(Playback, GivesTheTasksOfEachSegment) {
  RecordedFake recorded;
  recorded.SetOut();
  second_look::task_t task{};
  task.confidence = 0.75;
  recorded.recorder.Task(task);
  const Recording recording = recorded.EndWhole();
  Playback playback(recording);
  EXPECT_TRUE(playback.tasks().empty());
  playback.NextLook();
  ASSERT_EQ(playback.tasks().size(), 1U);
  EXPECT_EQ(playback.tasks()[0].confidence, 0.75);
}

TEST(Recording, OfAnotherFormatOrOfNothingIsRefused) {
  const TemporaryFolder folder;
  {
    transport::LogSink log(folder / "other", 1'000'000'000);
    second_look::rec_mission_t mission{};
    mission.format = 1;
    log.Post(transport::Pack(transport::channel::kRecMission, mission));
    transport::LogSink empty(folder / "empty", 1'000'000'000);
  }
  EXPECT_THROWS(Recording::Load(folder / "other"), ConfigError, "is a recording of format 1");
  EXPECT_THROWS(Recording::Load(folder / "empty"), ConfigError, "is no recording of a mission");
}

TEST(Recording, LeavesOutMessagesThatCannotBeRead) {
  RecordedFake recorded;
  recorded.robot.base->State();
  recorded.log.Post({transport::channel::kRecBaseState, 0, {1, 2, 3}});
  recorded.log.Post({transport::channel::kLook, 0, {1, 2, 3}});
  const Recording recording = recorded.EndWhole();
  EXPECT_EQ(recording.segments.size(), 1U);
  EXPECT_EQ(recording.segments[0].base_states.size(), 1U);
  EXPECT_THAT(recording.warnings, ElementsAre(HasSubstr("2 messages are damaged")));
}

TEST(Recording, CutOffAnywhereHoldsWhatCameBefore) {
  RecordedFake recorded;
  recorded.world.frames.push_back({Time{}, 1, cv::Mat(48, 64, CV_8UC3, cv::Scalar(1, 2, 3)),
                                   cv::Mat(48, 64, CV_32FC1, cv::Scalar(1.25))});
  for (int i = 0; i < 20; ++i) {
    recorded.world.X_WB.x = i;
    recorded.robot.base->State();
    if (i == 10) recorded.robot.head_camera->Grab(Seconds(1));
  }
  const Recording whole = recorded.EndWhole();
  const std::string bytes = ReadFile(recorded.folder / "log");
  std::size_t least = 0;
  for (std::size_t n = 0; n < bytes.size(); n += 7) {
    WriteFile(recorded.folder / "cut", bytes.substr(0, n));
    Recording cut;
    try {
      cut = Recording::Load(recorded.folder / "cut");
    } catch (const ConfigError&) {
      EXPECT_EQ(least, 0U) << "after " << n << " bytes";
      continue;
    }
    const Segment& segment = cut.segments.front();
    ASSERT_GE(segment.base_states.size(), least);
    least = segment.base_states.size();
    for (std::size_t i = 0; i < least; ++i) {
      EXPECT_EQ(std::get<BaseState>(segment.base_states[i]).X_WB.x, static_cast<double>(i));
    }
    EXPECT_FALSE(cut.complete);
    EXPECT_FALSE(cut.warnings.empty());
  }
  EXPECT_EQ(least, whole.segments.front().base_states.size());
}

// The contracts of clock and camera hold for recorded ones, too. Those of base and pan-tilt don't:
// they send the device to places of their own, and a recorded one goes where it went.

/// Ten frames of a simulated robot.
Recording RecordSimulated() {
  const TemporaryFolder folder;
  const auto simulated = sim::MakeShared(sim::FreeScene(), sim::NoiseConfig{}, 3);
  {
    transport::LogSink log(folder / "log", 1'000'000'000);
    Recorder recorder(&log);
    second_look::rec_mission_t mission{};
    Describe(simulated->robot, simulated->calibration, simulated->hand, &mission);
    recorder.Begin(mission);
    Robot tapped = Tap(std::move(simulated->robot), &recorder);
    for (int i = 0; i < 10; ++i) tapped.head_camera->Grab(Seconds(2));
    log.Post(transport::Pack(transport::channel::kMission, EndOfMission()));
  }
  return Recording::Load(folder / "log");
}

struct PlayedSim {
  Recording recording{RecordSimulated()};
  Playback playback{recording};
  Robot robot{playback.MakeRobot()};
};

std::vector<ClockFactory> Clocks() {
  return {{"Recorded", [] {
             const auto played = std::make_shared<PlayedSim>();
             return ClockRig{played->robot.clock.get(), played};
           }}};
}

std::vector<CameraFactory> Cameras() {
  return {{"Recorded", [] {
             const auto played = std::make_shared<PlayedSim>();
             return CameraRig{
                 played->robot.clock.get(), played->robot.head_camera.get(), {}, true, played};
           }}};
}

const auto kName = [](const auto& info) { return info.param.name; };

INSTANTIATE_TEST_SUITE_P(Recorded, CameraContract, ::testing::ValuesIn(Cameras()), kName);

}  // namespace
}  // namespace secondlook::hal

namespace secondlook {

INSTANTIATE_TEST_SUITE_P(Recorded, ClockContract, ::testing::ValuesIn(hal::Clocks()), hal::kName);

}  // namespace secondlook
