#include "apps/device_health.h"

#include <gtest/gtest.h>

#include "tests/support/fake_robot.h"

namespace secondlook::apps {
namespace {

using second_look::device_status_t;

constexpr Time At(double seconds) { return Time(Seconds(seconds)); }

struct Watched {
  testing::FakeWorld world;
  hal::Robot robot{testing::MakeFakeRobot(&world)};
  DeviceHealth health{robot};

  device_status_t Base(double now) const { return health.Status(At(now)).at(0); }
  device_status_t Head(double now) const { return health.Status(At(now)).at(1); }
  device_status_t Camera(double now) const { return health.Status(At(now)).at(2); }
};

hal::RgbdFrame Frame(double seconds, std::uint64_t sequence) {
  return {At(seconds), sequence, {}, {}};
}

TEST(DeviceHealth, KnowsEveryDeviceByNameAndKindBeforeAnyWasAsked) {
  const Watched watched;
  const auto all = watched.health.Status(At(0));
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].name + " " + all[0].kind, "wheels base");
  EXPECT_EQ(all[1].name + " " + all[1].kind, "neck pan_tilt");
  EXPECT_EQ(all[2].name + " " + all[2].kind, "eye camera");
  for (const device_status_t& device : all) {
    EXPECT_EQ(device.health, device_status_t::UNUSED);
    EXPECT_EQ(device.rate, 0.0);
    EXPECT_EQ(device.last_error, "");
  }
}

TEST(DeviceHealth, CountsEachMeasurementOfTheLastTenSecondsOnce) {
  Watched watched;
  for (int i = 1; i <= 300; ++i) {  // 20 Hz for 15 s, each asked for twice
    watched.health.OnBaseState({At(0.05 * i), {}, {}, {}});
    watched.health.OnBaseState({At(0.05 * i), {}, {}, {}});
  }
  EXPECT_EQ(watched.Base(15.0).health, device_status_t::OK);
  EXPECT_NEAR(watched.Base(15.0).rate, 20.0, 0.11);
  EXPECT_NEAR(watched.Base(20.0).rate, 10.0, 0.11);  // silent for half of the time
  EXPECT_EQ(watched.Head(15.0).rate, 0.0);
}

TEST(DeviceHealth, CallsACameraSilentUntilAFrameComes) {
  Watched watched;
  watched.health.OnFrame(std::nullopt, At(1));
  EXPECT_EQ(watched.Camera(1).health, device_status_t::SILENT);
  watched.health.OnFrame(Frame(2, 60), At(2));
  EXPECT_EQ(watched.Camera(2).health, device_status_t::OK);
}

TEST(DeviceHealth, CountsTheFramesThatNobodyTook) {
  Watched watched;
  watched.health.OnFrame(Frame(1, 30), At(1));
  EXPECT_EQ(watched.Camera(1).drops, 0);
  watched.health.OnFrame(Frame(2, 31), At(2));
  EXPECT_EQ(watched.Camera(2).drops, 0);
  watched.health.OnFrame(Frame(3, 35), At(3));  // 32, 33 and 34 are missing
  EXPECT_EQ(watched.Camera(3).drops, 3);
}

TEST(DeviceHealth, KeepsTheNewestErrorOfTheDeviceThatHadIt) {
  Watched watched;
  watched.health.OnHeadState({At(1), {}});
  watched.health.OnError(hal::Call::kHeadStart, InvalidArgument("pan 9 is beyond the limit"),
                         At(1));
  EXPECT_EQ(watched.Head(1).health, device_status_t::OK) << "the caller's fault";
  EXPECT_EQ(watched.Head(1).last_error, "pan 9 is beyond the limit");
  watched.health.OnError(hal::Call::kHeadState, DeviceError("the neck is lost"), At(2));
  EXPECT_EQ(watched.Head(2).health, device_status_t::FAILED);
  EXPECT_EQ(watched.Head(2).last_error, "the neck is lost");
  watched.health.OnBaseStatus({hal::MotionPhase::kFailed, "blocked after 1.2 m"});
  EXPECT_EQ(watched.Base(2).last_error, "blocked after 1.2 m");
  EXPECT_EQ(watched.Camera(2).last_error, "");
}

}  // namespace
}  // namespace secondlook::apps
