// The OpenNI2 camera, through the real library and a driver of our own for it. The library finds
// that by its configuration file alone, over which one of ours is mounted, for this process; that
// needs root, and without it these tests are skipped.

#include "lib/hal/drivers/openni2_camera.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include <dlfcn.h>
#include <poll.h>
#include <sched.h>
#include <sys/mount.h>

#include <OpenNI.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/hal/drivers/live_clock.h"
#include "tests/drivers/virtual_rgbd.h"
#include "tests/hal/camera_contract.h"
#include "tests/hal/clock_contract.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::hal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kIni = "/etc/openni2/OpenNI.ini";

/// The stock drivers play recordings; a repository of our own hides them. The player stays loaded
/// to the end, or what it leaks could not be told to be its own.
void LinkStockFilePlayer(const fs::path& drivers) {
  for (const char* folder :
       {"/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib"}) {
    const fs::path player = fs::path(folder) / "OpenNI2" / "Drivers" / "libOniFile.so.0";
    if (!fs::exists(player)) continue;
    fs::create_symlink(player, drivers / "libOniFile.so.0");
    dlopen(player.c_str(), RTLD_NOW | RTLD_NODELETE);
  }
}

/// The virtual camera in OpenNI2's list of devices; `missing` says why it is not.
struct VirtualDevices {
  TemporaryFolder folder;
  std::string missing;
  VirtualRgbd* shown{};

  VirtualDevices() {
    const fs::path driver = folder / "libVirtualRgbd.so.0";
    fs::create_symlink(SECONDLOOK_VIRTUAL_RGBD, driver);
    LinkStockFilePlayer(folder.path());
    WriteFile(folder / "OpenNI.ini", "[Drivers]\nRepository=" + folder.path().string() + "\n");
    if (unshare(CLONE_NEWNS) != 0 ||
        mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount((folder / "OpenNI.ini").c_str(), kIni, nullptr, MS_BIND, nullptr) != 0) {
      missing = "a configuration of our own cannot be mounted over " + std::string(kIni) +
                ": it needs root, and libopenni2-0";
      return;
    }
    // The same object as the library will load.
    void* object = dlopen(driver.c_str(), RTLD_NOW);
    const auto get = object == nullptr
                         ? nullptr
                         : reinterpret_cast<VirtualRgbd* (*)()>(dlsym(object, "TheVirtualRgbd"));
    if (get == nullptr) {
      missing = dlerror();
      return;
    }
    shown = get();
  }
};

VirtualDevices& Devices() {
  static VirtualDevices devices;
  return devices;
}

/// As it is at the start of a test.
void PlugIn() {
  Devices().shown->connected = true;
  Devices().shown->registers = true;
}

/// A camera and its clock.
struct Connected {
  LiveClock clock;
  std::unique_ptr<OpenNi2Camera> camera;

  explicit Connected(const OpenNi2Config& config = {})
      : camera(std::make_unique<OpenNi2Camera>(config, &clock)) {}
};

bool IsLost(OpenNi2Camera* camera) {
  try {
    camera->Grab(Seconds(0.1));
    return false;
  } catch (const DeviceError&) {
    return true;
  }
}

/// None where the virtual camera is missing.
std::vector<CameraFactory> Factories() {
  if (!Devices().missing.empty()) return {};
  return {{"Virtual", [] {
             PlugIn();
             const auto connected = std::make_shared<Connected>();
             const auto lose = [camera = connected->camera.get()] {
               Devices().shown->connected = false;
               while (!IsLost(camera)) {  // what was on its way still comes
               }
             };
             return CameraRig{&connected->clock, connected->camera.get(), lose, false, connected};
           }}};
}

const auto kName = [](const auto& info) { return info.param.name; };

INSTANTIATE_TEST_SUITE_P(OpenNi2, CameraContract, ::testing::ValuesIn(Factories()), kName);

class OpenNi2 : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!Devices().missing.empty()) GTEST_SKIP() << Devices().missing;
    PlugIn();
  }

  static RgbdFrame GrabOne(OpenNi2Camera* camera) {
    std::optional<RgbdFrame> frame;
    while (!frame) frame = camera->Grab(Seconds(1.0));
    return *frame;
  }

  /// Shows a ramp of depth with a pixel that has none, and a pixel that is red.
  static void ShowRamp() {
    VirtualRgbd& shown = *Devices().shown;
    const std::scoped_lock lock(shown.mutex);
    for (int u = 0; u < kVirtualWidth; ++u) {
      shown.depth_mm[static_cast<std::size_t>(u)] = static_cast<std::uint16_t>(801 + u);
    }
    shown.depth_mm[7] = 0;
    shown.rgb[0] = 200;
    shown.rgb[1] = 10;
    shown.rgb[2] = 20;
  }

  static void ExpectRamp(const RgbdFrame& frame) {
    EXPECT_FLOAT_EQ(frame.depth.at<float>(0, 0), 0.801F);
    EXPECT_FLOAT_EQ(frame.depth.at<float>(0, 639), 1.440F);
    EXPECT_TRUE(std::isnan(frame.depth.at<float>(0, 7)));
    EXPECT_EQ(frame.color.at<cv::Vec3b>(0, 0), cv::Vec3b(200, 10, 20));
  }
};

TEST_F(OpenNi2, GivesMetresAndRgb) {
  ShowRamp();
  Connected connected;
  ExpectRamp(GrabOne(connected.camera.get()));
}

TEST_F(OpenNi2, TakesItsIntrinsicsFromTheDeviceOrFromTheConfiguration) {
  // 640 px over 2 tan(1.0144686 rad / 2): 575.8 px, as the data sheet has it.
  EXPECT_NEAR(Connected().camera->info().model.fx, 575.8, 0.05);
  OpenNi2Config config;
  config.intrinsics = {525.0, 526.0, 320.0, 240.0};
  const CameraModel expected{640, 480, 525.0, 526.0, 320.0, 240.0};
  EXPECT_EQ(Connected(config).camera->info().model, expected);
}

TEST_F(OpenNi2, ComesBackAfterItWasUnplugged) {
  Connected connected;
  GrabOne(connected.camera.get());
  Devices().shown->connected = false;
  while (!IsLost(connected.camera.get())) {
  }
  Devices().shown->connected = true;
  while (IsLost(connected.camera.get())) poll(nullptr, 0, 10);
  EXPECT_FALSE(GrabOne(connected.camera.get()).color.empty());
}

TEST_F(OpenNi2, RefusesACameraThatCannotRegisterItsDepth) {
  Devices().shown->registers = false;
  EXPECT_THROWS(Connected(), DeviceError, "camera 'head': it cannot register depth to colour");
}

TEST_F(OpenNi2, NamesTheDeviceThatIsNotThere) {
  Devices().shown->connected = false;
  EXPECT_THROWS(Connected(), DeviceError, "camera 'head': any OpenNI2 device cannot be opened: ");
  OpenNi2Config config;
  config.uri = "/nowhere/recording.oni";
  EXPECT_THROWS(Connected(config), DeviceError, "/nowhere/recording.oni cannot be opened");
}

TEST_F(OpenNi2, NamesTheVideoModeThatItDoesNotHave) {
  OpenNi2Config config;
  config.width = 320;
  config.height = 240;
  EXPECT_THROWS(Connected(config), DeviceError, "it has no depth of 320 x 240 at 30 a second");
}

TEST_F(OpenNi2, PlaysARecording) {
  ShowRamp();
  const fs::path file = Devices().folder / "recorded.oni";
  ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
  {
    openni::Device device;
    ASSERT_EQ(device.open(openni::ANY_DEVICE), openni::STATUS_OK);
    openni::VideoStream depth;
    openni::VideoStream color;
    ASSERT_EQ(depth.create(device, openni::SENSOR_DEPTH), openni::STATUS_OK);
    ASSERT_EQ(color.create(device, openni::SENSOR_COLOR), openni::STATUS_OK);
    openni::Recorder recorder;
    ASSERT_EQ(recorder.create(file.c_str()), openni::STATUS_OK);
    recorder.attach(depth);
    recorder.attach(color);
    recorder.start();
    depth.start();
    color.start();
    openni::VideoFrameRef frame;
    for (int i = 0; i < 10; ++i) {
      depth.readFrame(&frame);
      color.readFrame(&frame);
    }
    recorder.stop();
    depth.stop();
    color.stop();
    recorder.destroy();
    depth.destroy();
    color.destroy();
  }
  OpenNi2Config config;
  config.uri = file.string();
  {
    Connected connected(config);
    ExpectRamp(GrabOne(connected.camera.get()));
  }
  openni::OpenNI::shutdown();
}

TEST(OpenNi2Config, RefusesValuesOutOfRange) {
  OpenNi2Config config;
  config.intrinsics = {525.0};
  EXPECT_THROWS(config.Validate(), ConfigError,
                "'intrinsics' has 1 values; give fx, fy, cx and cy");
  config.intrinsics.clear();
  config.max_depth = 0.1;
  EXPECT_THROWS(config.Validate(), ConfigError, "'max_depth' = 0.1 must lie in 0.4..100");
}

TEST(DeviceTime, TakesTheQuickestMessageForTheOffsetOfTheClocks) {
  DeviceTime device_time(Seconds(0.01));
  const auto at = [](double s) { return Time(Seconds(s)); };
  // The device's clock is 100 s behind; messages take 50, 20 and 80 ms.
  EXPECT_EQ(device_time.Of(Seconds(5.00), at(105.05)), at(105.04));
  EXPECT_EQ(device_time.Of(Seconds(6.00), at(106.02)), at(106.01));
  EXPECT_NEAR(ToSeconds(device_time.Of(Seconds(7.00), at(107.08))), 107.01, 1e-5);
}

TEST(DeviceTime, FollowsADeviceThatBeganAnew) {
  DeviceTime device_time(Duration::zero());
  const auto at = [](double s) { return Time(Seconds(s)); };
  device_time.Of(Seconds(500.0), at(600.0));
  EXPECT_EQ(device_time.Of(Seconds(0.1), at(605.0)), at(605.0));
}

INSTANTIATE_TEST_SUITE_P(Live, ClockContract,
                         ::testing::Values(ClockFactory{"Live",
                                                        [] {
                                                          const auto clock =
                                                              std::make_shared<LiveClock>();
                                                          return ClockRig{clock.get(), clock};
                                                        }}),
                         kName);

}  // namespace
}  // namespace secondlook::hal
