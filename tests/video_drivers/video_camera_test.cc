// The colour camera through OpenCV's VideoCapture, which plays numbered pictures here.

#include "lib/hal/drivers/video_camera.h"

#include <memory>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "lib/common/error.h"
#include "lib/hal/drivers/live_clock.h"
#include "tests/hal/camera_contract.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::hal {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

/// `count` pictures: blue, with a white dot at column 54, row 24.
struct Pictures {
  TemporaryFolder folder;

  explicit Pictures(int count) {
    cv::Mat bgr(kHeight, kWidth, CV_8UC3, cv::Scalar(200, 20, 10));
    bgr(cv::Rect(53, 23, 3, 3)).setTo(cv::Scalar(255, 255, 255));
    for (int i = 0; i < count; ++i) {
      cv::imwrite((folder / fmt::format("img_{:04}.png", i)).string(), bgr);
    }
  }

  VideoCameraConfig Config() const {
    VideoCameraConfig config;
    config.source = (folder / "img_%04d.png").string();
    config.width = kWidth;
    config.height = kHeight;
    config.intrinsics = {60.0, 60.0, 31.5, 23.5};
    return config;
  }
};

struct Connected {
  LiveClock clock;
  Pictures pictures;
  std::unique_ptr<VideoCamera> camera;

  explicit Connected(int count)
      : pictures(count), camera(std::make_unique<VideoCamera>(pictures.Config(), &clock)) {}
};

RgbdFrame GrabOne(VideoCamera* camera) {
  std::optional<RgbdFrame> frame;
  while (!frame) frame = camera->Grab(Seconds(1.0));
  return *frame;
}

const auto kName = [](const auto& info) { return info.param.name; };

INSTANTIATE_TEST_SUITE_P(
    Video, CameraContract,
    ::testing::Values(CameraFactory{
        "Pictures",
        [] {
          const auto connected = std::make_shared<Connected>(300);
          return CameraRig{&connected->clock, connected->camera.get(), {}, false, connected};
        }}),
    kName);

TEST(VideoCamera, GivesRgb) {
  Connected connected(100);
  const RgbdFrame frame = GrabOne(connected.camera.get());
  EXPECT_EQ(frame.color.at<cv::Vec3b>(5, 5), cv::Vec3b(10, 20, 200));
  EXPECT_TRUE(frame.depth.empty());
}

TEST(VideoCamera, TakesTheLensOutOfItsFrames) {
  const LiveClock clock;
  const Pictures pictures(100);
  VideoCameraConfig config = pictures.Config();
  config.distortion = {-0.2, 0.0, 0.0, 0.0, 0.0};
  VideoCamera camera(config, &clock);
  const cv::Mat color = GrabOne(&camera).color;
  // The dot was seen at x = (54 - 31.5) / 60 = 0.375. It truly lies at the x of which
  // x (1 - 0.2 x^2) = 0.375, i.e. 0.3867: 0.3867 * 60 + 31.5 = 54.7 px.
  double sum = 0.0;
  double weights = 0.0;
  for (int u = 45; u < kWidth; ++u) {
    const double weight = color.at<cv::Vec3b>(24, u)[0] - 10.0;  // the background's red is 10
    if (weight <= 0.0) continue;
    sum += weight * u;
    weights += weight;
  }
  EXPECT_NEAR(sum / weights, 54.7, 0.2);
}

TEST(VideoCamera, IsLostWhenItsPicturesEnd) {
  Connected connected(5);
  const auto all = [&] {
    while (true) connected.camera->Grab(Seconds(1.0));
  };
  EXPECT_THROWS(all(), DeviceError, "camera 'hand': ");
  EXPECT_THROWS(all(), DeviceError, "img_%04d.png has ended");
}

TEST(VideoCamera, NamesWhatCannotBeOpenedOrHasAnotherSize) {
  const LiveClock clock;
  const Pictures pictures(2);
  VideoCameraConfig config = pictures.Config();
  config.width = 32;
  EXPECT_THROWS(VideoCamera(config, &clock), DeviceError,
                "gives 64 x 48 with 3 channels, and not 32 x 48 with 3: set width, height");
  config.source = "/dev/videoNone";
  EXPECT_THROWS(VideoCamera(config, &clock), DeviceError,
                "camera 'hand': /dev/videoNone cannot be opened: is it plugged in");
}

TEST(VideoCameraConfig, RefusesValuesThatAreNone) {
  VideoCameraConfig config;
  EXPECT_THROWS(config.Validate(), ConfigError, "'intrinsics' has 0 values; give fx, fy, cx");
  config.intrinsics = {500.0, 500.0, 320.0, 240.0};
  EXPECT_NO_THROW(config.Validate());
  config.distortion = {0.1};
  EXPECT_THROWS(config.Validate(), ConfigError, "'distortion' has 1 values; give k1, k2, p1, p2");
  config.distortion.clear();
  config.source.clear();
  EXPECT_THROWS(config.Validate(), ConfigError, "'source' is empty: give a device");
}

}  // namespace
}  // namespace secondlook::hal
