#pragma once

#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lib/common/clock.h"
#include "lib/common/error.h"
#include "lib/hal/camera.h"
#include "tests/support/expect_throws.h"

namespace secondlook::hal {

/// A camera to be held to what lib/hal/camera.h promises, and the clock of its robot. It must be
/// able to deliver at least 10 frames, each within 2 s of the one before.
struct CameraRig {
  Clock* clock{};
  Camera* camera{};
  std::function<void()> lose;   ///< Breaks the connection for good; empty: it cannot break.
  bool recorded{};              ///< Its frames come as they came, however they are asked for.
  std::shared_ptr<void> owner;  ///< Keeps all alive; of a type that only the factory knows.
};

/// Makes the same kind of camera anew for each test.
struct CameraFactory {
  std::string name;  ///< Of the backend, in the names of the tests.
  std::function<CameraRig()> make;

  friend void PrintTo(const CameraFactory& factory, std::ostream* out) { *out << factory.name; }
};

class CameraContract : public ::testing::TestWithParam<CameraFactory> {
 protected:
  CameraContract() : rig_(GetParam().make()), clock_(*rig_.clock), camera_(*rig_.camera) {}

  RgbdFrame GrabOne() {
    std::optional<RgbdFrame> frame = camera_.Grab(Seconds(2));
    EXPECT_TRUE(frame.has_value()) << "no frame within 2 s";
    return frame.value_or(RgbdFrame{});
  }

  CameraRig rig_;
  Clock& clock_;
  Camera& camera_;
};

TEST_P(CameraContract, InfoIsValid) {
  const CameraInfo& info = camera_.info();
  EXPECT_FALSE(info.name.empty());
  EXPECT_NO_THROW(info.model.Validate("camera"));
  if (info.has_depth) {
    EXPECT_LT(info.min_depth, info.max_depth);
    EXPECT_GE(info.min_depth, 0.0);
  } else {
    EXPECT_EQ(info.max_depth, 0.0);
  }
}

TEST_P(CameraContract, InfoIsConstant) {
  const CameraModel before = camera_.info().model;
  GrabOne();
  EXPECT_TRUE(before == camera_.info().model);
}

TEST_P(CameraContract, FramesMatchTheModel) {
  const RgbdFrame frame = GrabOne();
  const CameraInfo& info = camera_.info();
  EXPECT_EQ(frame.color.type(), CV_8UC3);
  EXPECT_EQ(frame.color.size(), cv::Size(info.model.width, info.model.height));
  if (info.has_depth) {
    EXPECT_EQ(frame.depth.type(), CV_32FC1);
    EXPECT_EQ(frame.depth.size(), frame.color.size());
  } else {
    EXPECT_TRUE(frame.depth.empty());
  }
}

TEST_P(CameraContract, TimeAndSequenceStrictlyIncrease) {
  RgbdFrame last = GrabOne();
  for (int i = 0; i < 5; ++i) {
    const RgbdFrame frame = GrabOne();
    EXPECT_GT(frame.time, last.time);
    EXPECT_GT(frame.sequence, last.sequence);
    last = frame;
  }
}

TEST_P(CameraContract, AFrameIsNotFromTheFuture) {
  for (int i = 0; i < 5; ++i) {
    const RgbdFrame frame = GrabOne();
    EXPECT_LE(frame.time, clock_.Now());
  }
}

TEST_P(CameraContract, KeptFramesAreNotOverwritten) {
  const RgbdFrame kept = GrabOne();
  const cv::Mat color = kept.color.clone();
  const cv::Mat depth = kept.depth.clone();
  for (int i = 0; i < 4; ++i) GrabOne();
  const auto same = [](const cv::Mat& a, const cv::Mat& b) {
    if (a.size() != b.size() || a.type() != b.type()) return false;
    return a.empty() || std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
  };
  EXPECT_TRUE(same(color, kept.color));
  EXPECT_TRUE(same(depth, kept.depth));
}

TEST_P(CameraContract, ZeroTimeoutNeverWaits) {
  if (rig_.recorded) GTEST_SKIP() << "what it waited for was recorded";
  const Time before = clock_.Now();
  for (int i = 0; i < 3; ++i) camera_.Grab(Duration::zero());
  EXPECT_LT(clock_.Now() - before, Seconds(0.02));
}

TEST_P(CameraContract, AFrameIsReturnedOnce) {
  GrabOne();
  const RgbdFrame frame = GrabOne();
  // At once there is nothing newer, or it is another frame.
  const std::optional<RgbdFrame> next = camera_.Grab(Duration::zero());
  if (next) {
    EXPECT_GT(next->sequence, frame.sequence);
  }
}

TEST_P(CameraContract, TheNewestFrameIsReturnedAndOlderOnesAreLost) {
  if (rig_.recorded) GTEST_SKIP() << "which frames are lost was decided when it was recorded";
  const RgbdFrame first = GrabOne();
  clock_.SleepUntil(clock_.Now() + Seconds(1));
  const RgbdFrame second = GrabOne();
  EXPECT_GT(second.time, first.time + Seconds(0.5));
}

TEST_P(CameraContract, DepthIsNanOrWithinItsRange) {
  if (!camera_.info().has_depth) GTEST_SKIP() << "no depth";
  const RgbdFrame frame = GrabOne();
  int measured = 0;
  for (int v = 0; v < frame.depth.rows; ++v) {
    for (int u = 0; u < frame.depth.cols; ++u) {
      const float z = frame.depth.at<float>(v, u);
      if (std::isnan(z)) continue;
      ++measured;
      ASSERT_GE(z, camera_.info().min_depth) << "at " << u << ", " << v;
      ASSERT_LE(z, camera_.info().max_depth) << "at " << u << ", " << v;
    }
  }
  EXPECT_GT(measured, 0);
}

TEST_P(CameraContract, GrabAfterLossThrowsDeviceErrorNamingTheCamera) {
  if (!rig_.lose) GTEST_SKIP() << "this backend cannot be lost";
  GrabOne();
  rig_.lose();
  EXPECT_THROWS(camera_.Grab(Seconds(2)), DeviceError, camera_.info().name);
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(CameraContract);

}  // namespace secondlook::hal
