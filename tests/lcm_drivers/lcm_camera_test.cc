// Images that come over LCM, from a camera that is emulated on the same link.

#include "lib/hal/drivers/lcm_camera.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/hal/drivers/live_clock.h"
#include "lib/hal/drivers/rgbd_message.h"
#include "tests/hal/camera_contract.h"
#include "tests/lcm_drivers/lcm_camera_emulator.h"
#include "tests/support/expect_throws.h"

namespace secondlook::hal {
namespace {

using bot_core::image_t;
using bot_core::images_t;

constexpr int kWidth = 32;
constexpr int kHeight = 24;

LcmCameraConfig Config() {
  LcmCameraConfig config;
  config.width = kWidth;
  config.height = kHeight;
  config.intrinsics = {30.0, 30.0, 15.5, 11.5};
  config.patience_seconds = 0.5;
  return config;
}

CameraInfo Info() { return {"head", {kWidth, kHeight, 30.0, 30.0, 15.5, 11.5}, true, 0.3, 5.0}; }

/// A ramp of depth with one pixel that has none, and another that is too near.
RgbdFrame Ramp(Time time) {
  RgbdFrame frame{time, 0, cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar(200, 100, 50)),
                  cv::Mat(kHeight, kWidth, CV_32FC1)};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      frame.depth.at<float>(v, u) = 1.0F + 0.001F * static_cast<float>(u);
    }
  }
  frame.depth.at<float>(0, 7) = std::numeric_limits<float>::quiet_NaN();
  frame.depth.at<float>(0, 8) = 0.2F;
  return frame;
}

void ExpectRamp(const cv::Mat& depth) {
  EXPECT_FLOAT_EQ(depth.at<float>(0, 0), 1.0F);
  EXPECT_FLOAT_EQ(depth.at<float>(23, 31), 1.031F);
  EXPECT_TRUE(std::isnan(depth.at<float>(0, 7)));
  EXPECT_TRUE(std::isnan(depth.at<float>(0, 8)));
}

/// A camera, its emulated device, and the network between them.
struct Connected {
  LiveClock clock;
  std::shared_ptr<LcmLink> link = std::make_shared<LcmLink>("memq://");
  LcmCameraEmulator emulator{link.get(), "CAMERA", [this] { return Ramp(clock.Now()); }};
  std::unique_ptr<LcmCamera> camera;

  explicit Connected(const LcmCameraConfig& config = Config())
      : camera(std::make_unique<LcmCamera>(config, link, &clock)) {}

  /// The next frame, also when the camera is lost at first.
  RgbdFrame GrabOne() const {
    while (true) {
      try {
        if (std::optional<RgbdFrame> frame = camera->Grab(Seconds(1.0))) return *frame;
      } catch (const DeviceError&) {
      }
    }
  }

  /// What the camera says when it is lost because each message was spoilt in this way.
  std::string LostBy(std::function<void(images_t*)> spoil) {
    emulator.Spoil({});
    GrabOne();
    emulator.Spoil(std::move(spoil));
    return Lost();
  }

  /// What the camera says once it is lost.
  std::string Lost() const {
    try {
      while (true) camera->Grab(Seconds(1.0));
    } catch (const DeviceError& error) {
      return error.what();
    }
  }
};

CameraFactory Factory(const std::string& name, bool synchronised) {
  return {name, [synchronised] {
            LcmCameraConfig config = Config();
            config.synchronised = synchronised;
            const auto connected = std::make_shared<Connected>(config);
            const auto lose = [c = connected.get()] {
              c->LostBy([](images_t* message) { message->image_types[0] = images_t::DISPARITY; });
            };
            return CameraRig{&connected->clock, connected->camera.get(), lose, false, connected};
          }};
}

const auto kName = [](const auto& info) { return info.param.name; };

INSTANTIATE_TEST_SUITE_P(Lcm, CameraContract,
                         ::testing::Values(Factory("Synchronised", true),
                                           Factory("WithAClockOfItsOwn", false)),
                         kName);

TEST(LcmCamera, MaySendColorAlone) {
  LcmCameraConfig config = Config();
  config.depth = false;
  Connected connected(config);
  EXPECT_FALSE(connected.camera->info().has_depth);
  const RgbdFrame frame = connected.GrabOne();
  EXPECT_TRUE(frame.depth.empty());
  EXPECT_EQ(frame.color.size(), cv::Size(kWidth, kHeight));
}

TEST(LcmCamera, GivesMetresAndRgb) {
  Connected connected;
  const RgbdFrame frame = connected.GrabOne();
  ExpectRamp(frame.depth);
  const auto pixel = frame.color.at<cv::Vec3b>(12, 16);
  EXPECT_NEAR(pixel[0], 200, 3);  // JPEG
  EXPECT_NEAR(pixel[1], 100, 3);
  EXPECT_NEAR(pixel[2], 50, 3);
}

TEST(LcmCamera, ComesBackAfterItWasLost) {
  Connected connected;
  connected.emulator.SetSilent(true);
  EXPECT_THAT(connected.Lost(), ::testing::HasSubstr("camera 'head': nothing came on channel "
                                                     "'CAMERA' of memq:// for 0.5 s: is its"));
  connected.emulator.SetSilent(false);
  ExpectRamp(connected.GrabOne().depth);
}

TEST(LcmCamera, IsNotThereWhenNothingComesOrNothingGood) {
  const auto link = std::make_shared<LcmLink>("memq://");
  const LiveClock clock;
  EXPECT_THROWS(LcmCamera(Config(), link, &clock), DeviceError, "nothing came on channel");
  LcmCameraConfig twice = Config();
  twice.width = 64;
  EXPECT_THROWS(Connected{twice}, DeviceError,
                "colour is 32 x 24, and the intrinsics are those of 64 x 24: send it in that size");
}

TEST(LcmCamera, SaysWhatIsWrongWithStamps) {
  using ::testing::HasSubstr;
  Connected connected;
  const auto shift = [](double seconds) {
    return [seconds](images_t* message) {
      for (image_t& image : message->images) {
        image.utime += static_cast<std::int64_t>(1e6 * seconds);
      }
    };
  };
  EXPECT_THAT(connected.LostBy(shift(90.0)), HasSubstr("ahead of this machine's clock: keep the"));
  EXPECT_THAT(connected.LostBy(shift(-90.0)), HasSubstr("behind this machine's clock"));
  EXPECT_THAT(connected.LostBy([](images_t* m) { m->images[1].utime -= 300'000; }),
              HasSubstr("colour and depth were taken 0.300 s apart, at most 0.020 s are taken"));
  EXPECT_THAT(connected.LostBy([](images_t* m) { m->images[0].utime = -5; }),
              HasSubstr("its stamp of -5 us is none"));
  EXPECT_THAT(connected.LostBy([kept = std::int64_t{}](images_t* m) mutable {
    if (kept == 0) kept = m->images[0].utime;
    for (image_t& image : m->images) image.utime = kept;
  }),
              HasSubstr("its stamps do not advance: is the camera stuck"));
}

TEST(LcmCamera, BoundsAMessageBeforeDecodingIt) {
  Connected connected;
  const std::string said = connected.LostBy([](images_t* message) {
    message->images[0].data.resize(20'000);
    message->images[0].size = 20'000;
  });
  EXPECT_NE(said.find("'data' has 20000 bytes, at most 7168 are taken"), std::string::npos) << said;
}

TEST(LcmCamera, RefusesAConfigurationThatIsNone) {
  LcmCameraConfig config = Config();
  config.intrinsics.clear();
  EXPECT_THROWS(config.Validate(), ConfigError, "'intrinsics' has 0 values; give fx, fy, cx and");
  config = Config();
  config.max_depth = 0.1;
  EXPECT_THROWS(config.Validate(), ConfigError, "'max_depth' = 0.1 must lie in 0.3..65");
  config = Config();
  config.channel.clear();
  EXPECT_THROWS(config.Validate(), ConfigError, "'channel' is empty");
}

class RgbdMessage : public ::testing::Test {
 protected:
  RgbdMessage() : raw_(WriteRawImages(Ramp(Time(Seconds(7.0))))) {}

  ReceivedImages Read() const { return ReadImages(raw_, Info(), Seconds(0.02)); }

  images_t raw_;
};

TEST_F(RgbdMessage, HoldsImagesAsTheyAre) {
  const ReceivedImages images = Read();
  EXPECT_EQ(images.stamp, Seconds(7.0));
  EXPECT_EQ(images.color.at<cv::Vec3b>(23, 31), cv::Vec3b(200, 100, 50));
  ExpectRamp(images.depth);
}

TEST_F(RgbdMessage, MayHaveRowsThatAreFilledUp) {
  image_t& depth = raw_.images[1];
  std::vector<std::uint8_t> wide(kHeight * 80U, 0xee);
  for (int v = 0; v < kHeight; ++v) {
    std::memcpy(wide.data() + 80 * v, depth.data.data() + 2 * kWidth * v, 2 * kWidth);
  }
  depth.data = wide;
  depth.row_stride = 80;
  ExpectRamp(Read().depth);
}

TEST_F(RgbdMessage, IsRefusedWhenItsRowsDoNotFit) {
  raw_.images[1].data.pop_back();
  EXPECT_THROWS(Read(), ProtocolError,
                "depth: 1535 bytes with 64 a row do not hold 32 x 24 pixels");
  raw_.images[1].row_stride = 63;
  EXPECT_THROWS(Read(), ProtocolError, "with 63 a row");
  raw_.images[1].row_stride = -64;
  EXPECT_THROWS(Read(), ProtocolError, "with -64 a row");
}

TEST_F(RgbdMessage, IsRefusedWithoutDepthOrColor) {
  raw_.image_types[1] = images_t::DISPARITY;
  EXPECT_THROWS(Read(), ProtocolError, "no depth among its 2 images: send colour as LEFT (0) and");
  raw_.image_types[0] = images_t::DISPARITY;
  EXPECT_THROWS(Read(), ProtocolError, "no colour among its 2 images");
}

TEST_F(RgbdMessage, IsRefusedInAFormatThatNobodyReads) {
  raw_.images[0].pixelformat = image_t::PIXEL_FORMAT_GRAY;
  EXPECT_THROWS(Read(), ProtocolError,
                "colour has pixel format 1497715271: send MJPEG (1196444237)");
  raw_.images[0].pixelformat = image_t::PIXEL_FORMAT_MJPEG;
  EXPECT_THROWS(Read(), ProtocolError, "colour is sent as MJPEG, and its 2304 bytes are none");
}

TEST_F(RgbdMessage, IsRefusedWhenItsStreamHoldsMoreOrLess) {
  raw_.image_types[1] = images_t::DEPTH_MM_ZIPPED;
  EXPECT_THROWS(Read(), ProtocolError, "does not hold the 1536 bytes it should");
}

TEST_F(RgbdMessage, IsRefusedForTheSizeInItsJpegBeforeThatIsDecoded) {
  images_t jpeg = WriteImages(Ramp(Time(Seconds(7.0))));
  ASSERT_EQ(JpegSize(jpeg.images[0].data), cv::Size(kWidth, kHeight));
  // The frame header of a baseline JPEG is ff c0, its length, a byte of precision, rows, columns.
  std::vector<std::uint8_t>& data = jpeg.images[0].data;
  std::size_t header = 2;
  while (data[header] != 0xff || data[header + 1] != 0xc0) ++header;
  data[header + 5] = data[header + 6] = data[header + 7] = data[header + 8] = 0xff;
  EXPECT_THROWS(ReadImages(jpeg, Info(), Seconds(0.02)), ProtocolError,
                "the JPEG of colour is 65535 x 65535, and the intrinsics are those of 32 x 24");
  data.resize(header + 4);
  EXPECT_EQ(JpegSize(data), std::nullopt);
}

}  // namespace
}  // namespace secondlook::hal
