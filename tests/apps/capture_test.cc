#include "apps/capture.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"
#include "tests/support/fake_robot.h"

namespace secondlook::apps {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

hal::RgbdFrame FrameAt(double seconds, std::uint64_t sequence) {
  hal::RgbdFrame frame;
  frame.time = Time(Seconds(seconds));
  frame.sequence = sequence;
  frame.depth = cv::Mat(48, 64, CV_32FC1, cv::Scalar(1.0));
  return frame;
}

class Capturing : public ::testing::Test {
 protected:
  Capturing() : robot_(testing::MakeFakeRobot(&world_)) {}

  testing::FakeWorld world_;
  hal::Robot robot_;
  Capturer capturer_{&robot_, kinematics::HeadCalibration::AtHeight(1.25)};
};

TEST_F(Capturing, PutsTheCameraWhereBaseAndHeadStandStill) {
  // The base is at (2, 3) and faces +y; the head looks 90 degrees to its left: along -x of W.
  world_.X_WB = {2.0, 3.0, std::numbers::pi / 2.0};
  world_.angles = {std::numbers::pi / 2.0, 0.0};
  world_.frames = {FrameAt(0.06, 1)};
  const Capture capture = capturer_.Take(Seconds(1.0)).value();
  EXPECT_TRUE(capture.X_WC.translation().isApprox(Eigen::Vector3d(2.0, 3.0, 1.25), 1e-9));
  EXPECT_TRUE(capture.X_WC.linear().col(2).isApprox(-Eigen::Vector3d::UnitX(), 1e-9));
  EXPECT_TRUE(capture.X_WC.linear().col(1).isApprox(-Eigen::Vector3d::UnitZ(), 1e-9));
  EXPECT_TRUE(capture.p_CB_W.isApprox(Eigen::Vector3d(0.0, 0.0, -1.25), 1e-9));
  EXPECT_EQ(capture.camera, robot_.head_camera->info().model);
}

TEST_F(Capturing, TakesThePoseAtTheTimeOfTheFrameNotOfItsArrival) {
  // A head that turns at 1 rad/s has turned by as many rad as the frame's time has seconds.
  world_.pan_speed = 1.0;
  world_.frames = {FrameAt(0.08, 1)};
  const Capture capture = capturer_.Take(Seconds(1.0)).value();
  const Eigen::Vector3d ahead_W = capture.X_WC.linear().col(2);
  EXPECT_NEAR(std::atan2(ahead_W.y(), ahead_W.x()), 0.08, 1e-6);
}

TEST_F(Capturing, SkipsFramesFromBeforeTheLastMotionEnded) {
  world_.now = Time(Seconds(10.0));
  world_.frames = {FrameAt(9.0, 1), FrameAt(9.5, 2), FrameAt(10.02, 3), FrameAt(10.1, 4)};
  EXPECT_EQ(capturer_.Take(Seconds(1.0)).value().frame.sequence, 3U);
}

TEST_F(Capturing, GivesUpOnACameraWhoseStampsLag) {
  world_.now = Time(Seconds(10.0));
  for (int i = 0; i < 20; ++i) world_.frames.push_back(FrameAt(8.0 + 0.01 * i, i + 1));
  EXPECT_THROWS(capturer_.Take(Seconds(1.0)), DeviceError, "check its clock and its time stamps");
}

TEST_F(Capturing, GivesUpOnACameraWhoseStampsLieInTheFuture) {
  world_.frames = {FrameAt(3600.0, 1)};
  EXPECT_THROWS(capturer_.Take(Seconds(1.0)), DeviceError, "ahead of the robot's clock");
}

TEST_F(Capturing, GivesUpOnDevicesWhoseStampsLieInTheFuture) {
  // Between a state of now and one of the future all that is asked for would be a guess.
  world_.now = Time(Seconds(10.0));
  world_.state_lag = Seconds(-5.0);
  EXPECT_THROWS(capturer_.Poll(), DeviceError,
                "base 'wheels': its newest state is stamped 5.000 s ahead of the robot's clock");
}

TEST_F(Capturing, GivesUpOnABaseWhoseStampsDoNotCoverTheFrame) {
  world_.state_lag = Seconds(5.0);
  world_.now = Time(Seconds(10.0));
  world_.frames = {FrameAt(10.06, 1)};
  EXPECT_THROWS(capturer_.Take(Seconds(1.0)), DeviceError, "no pose for its frame 1");
}

TEST_F(Capturing, IsEmptyWhenNoFrameComesInTime) {
  EXPECT_FALSE(capturer_.Take(Seconds(0.7)).has_value());
  EXPECT_EQ(world_.grabs, 1);
  EXPECT_NEAR(ToSeconds(world_.now), 0.75, 1e-9);  // 0.05 s to settle, then the timeout
}

TEST(ShareWithDepth, CountsThePixelsThatWereMeasured) {
  cv::Mat depth(1, 4, CV_32FC1, cv::Scalar(kNan));
  EXPECT_EQ(ShareWithDepth(depth), 0.0);
  depth.at<float>(0, 1) = 0.8F;
  EXPECT_EQ(ShareWithDepth(depth), 0.25);
  depth.setTo(2.0F);
  EXPECT_EQ(ShareWithDepth(depth), 1.0);
  EXPECT_EQ(ShareWithDepth(cv::Mat()), 0.0);
}

}  // namespace
}  // namespace secondlook::apps
