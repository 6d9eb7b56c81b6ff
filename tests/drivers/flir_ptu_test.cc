// The driver of the pan-tilt unit, through a real serial line to an emulated one.

#include "lib/hal/drivers/flir_ptu.h"

#include <functional>
#include <memory>
#include <numbers>
#include <string>

#include <poll.h>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/drivers/ptu_emulator.h"
#include "tests/hal/pan_tilt_contract.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::hal {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// A driver and the unit it speaks with.
struct Unit {
  TemporaryFolder folder;
  SteppedClock clock;
  PtuEmulator emulator{&clock, folder.path()};
  std::unique_ptr<FlirPtu> head;

  FlirPtuConfig Config() const {
    FlirPtuConfig config;
    config.device = emulator.port();
    config.speed_deg = 120.0;
    config.poll_seconds = 0.001;
    return config;
  }
  void Connect() { head = std::make_unique<FlirPtu>(Config(), &clock); }
};

/// Waits for what another thread brings about, without a limit that a slow machine could exceed
/// before the test's own.
void WaitUntil(const std::function<bool()>& true_at_last) {
  while (!true_at_last()) poll(nullptr, 0, 1);
}

bool IsLost(FlirPtu* head) {
  try {
    head->State();
    return false;
  } catch (const DeviceError&) {
    return true;
  }
}

MotionStatus WaitForEnd(Unit* unit) {
  while (unit->head->Status().phase == MotionPhase::kMoving) {
    unit->clock.SleepUntil(unit->clock.Now() + Seconds(0.05));
    poll(nullptr, 0, 1);
  }
  return unit->head->Status();
}

PanTiltFactory Factory(const std::string& name, PtuFault fault) {
  return {name, [fault] {
            const auto unit = std::make_shared<Unit>();
            unit->emulator.Set(fault);
            unit->Connect();
            return PanTiltRig{&unit->clock, unit->head.get(), unit};
          }};
}

const auto kName = [](const auto& info) { return info.param.name; };

INSTANTIATE_TEST_SUITE_P(Flir, PanTiltContract,
                         ::testing::Values(Factory("Sound", PtuFault::kNone),
                                           Factory("WithGarbageOnTheLine", PtuFault::kGarbage)),
                         kName);

TEST(FlirPtu, ReadsItsLimitsFromTheUnit) {
  Unit unit;
  unit.Connect();
  // The data sheet: 185.1428 arc seconds a count; pan 3090 counts to either side, tilt 604 up and
  // 907 down. Ours counts tilt downwards.
  const PanTiltInfo& info = unit.head->info();
  EXPECT_NEAR(info.upper.pan, 158.91 * kDegree, 0.01 * kDegree);
  EXPECT_NEAR(info.lower.pan, -158.91 * kDegree, 0.01 * kDegree);
  EXPECT_NEAR(info.lower.tilt, -31.06 * kDegree, 0.01 * kDegree);
  EXPECT_NEAR(info.upper.tilt, 46.65 * kDegree, 0.01 * kDegree);
  EXPECT_NEAR(info.speed, 120.0 * kDegree, 1e-9);  // the unit could do 149
}

TEST(FlirPtu, SendsCountsWithTheSignsOfTheUnit) {
  Unit unit;
  unit.Connect();
  unit.head->Start({0.5, 0.25});
  ASSERT_EQ(WaitForEnd(&unit).phase, MotionPhase::kReached);
  // 0.25 rad down / (185.1428 arc seconds) = 278.5 counts
  EXPECT_EQ(unit.emulator.last_command(), "tp-279");
}

TEST(FlirPtu, HaltsTheUnitAtTheEnd) {
  Unit unit;
  unit.Connect();
  unit.head->Start({1.0, 0.0});
  unit.clock.SleepUntil(unit.clock.Now() + Seconds(0.1));
  unit.head.reset();
  EXPECT_EQ(unit.emulator.last_command(), "h");
}

TEST(FlirPtu, FailsWithBothPlacesWhenTheUnitDoesNotMove) {
  Unit unit;
  unit.Connect();
  unit.emulator.Set(PtuFault::kStuck);
  unit.head->Start({0.5, 0.0});
  const MotionStatus status = WaitForEnd(&unit);
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_NE(status.reason.find("stands still at pan 0.00, tilt 0.00 deg and not at pan 28.65"),
            std::string::npos)
      << status.reason;
}

TEST(FlirPtu, IsLostWhileTheUnitIsSilentAndBackAfterwards) {
  Unit unit;
  unit.Connect();
  unit.head->Start({1.0, 0.0});
  unit.emulator.Set(PtuFault::kSilent);
  WaitUntil([&] { return IsLost(unit.head.get()); });
  EXPECT_EQ(unit.head->Status().phase, MotionPhase::kFailed);
  EXPECT_THROWS(unit.head->State(), DeviceError, "is it the right port, powered, ");
  EXPECT_THROWS(unit.head->Start({0.0, 0.0}), DeviceError, "no answer to");
  unit.emulator.Set(PtuFault::kNone);
  WaitUntil([&] { return !IsLost(unit.head.get()); });
  unit.head->Start({0.2, 0.1});
  EXPECT_EQ(WaitForEnd(&unit).phase, MotionPhase::kReached);
}

TEST(FlirPtu, SurvivesUnplugging) {
  Unit unit;
  unit.Connect();
  unit.emulator.Set(PtuFault::kUnplugged);
  WaitUntil([&] { return IsLost(unit.head.get()); });
  unit.head->Stop();  // possible all the same
  unit.emulator.Set(PtuFault::kNone);
  WaitUntil([&] { return !IsLost(unit.head.get()); });
  unit.head->Start({-0.3, 0.0});
  EXPECT_EQ(WaitForEnd(&unit).phase, MotionPhase::kReached);
}

TEST(FlirPtu, HomesWhenAsked) {
  Unit unit;
  FlirPtuConfig config = unit.Config();
  config.home = true;
  unit.head = std::make_unique<FlirPtu>(config, &unit.clock);
  EXPECT_EQ(unit.head->State().angles, PanTiltAngles{});
}

TEST(FlirPtu, SaysWhatIsWrongWithItsPort) {
  SteppedClock clock;
  FlirPtuConfig config;
  config.device = "/dev/ttyNone";
  EXPECT_THROWS(FlirPtu(config, &clock), DeviceError,
                "/dev/ttyNone: cannot be opened: No such file or directory: is it plugged in");
  config.baud = 1234;
  EXPECT_THROWS(FlirPtu(config, &clock), ConfigError, "1234 baud: expected 9600");
  config.device.clear();
  EXPECT_THROWS(FlirPtu(config, &clock), ConfigError, "'device' is empty");
}

TEST(FlirPtu, IsNotThereWhenNothingAnswers) {
  Unit unit;
  unit.emulator.Set(PtuFault::kSilent);
  EXPECT_THROWS(unit.Connect(), DeviceError, "no answer to 'ft' from the pan-tilt unit");
}

TEST(FlirPtu, IsNotThereWhenAnotherDeviceTalks) {
  Unit unit;
  unit.emulator.Set(PtuFault::kTalks);
  EXPECT_THROWS(unit.Connect(), DeviceError, "no answer to 'ft' from the pan-tilt unit");
}

}  // namespace
}  // namespace secondlook::hal
