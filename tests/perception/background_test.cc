#include "lib/perception/background.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::perception {
namespace {

constexpr int kWidth = 80;
constexpr int kHeight = 60;
const geometry::CameraModel kCamera{kWidth, kHeight, 70.0, 70.0, 39.5, 29.5};

/// A table of two colours, with the noise of a frame; `draw` puts things on it before that.
template <class Draw>
cv::Mat Frame(Rng* rng, Draw draw) {
  cv::Mat frame(kHeight, kWidth, CV_8UC3, cv::Scalar(150, 120, 80));
  frame(cv::Rect(40, 0, 40, kHeight)).setTo(cv::Scalar(90, 100, 110));
  draw(&frame);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    cv::Vec3b& pixel = frame.at<cv::Vec3b>(i / kWidth, i % kWidth);
    for (int c = 0; c < 3; ++c)
      pixel[c] = cv::saturate_cast<std::uint8_t>(pixel[c] + rng->Gaussian(4.0));
  }
  return frame;
}

cv::Mat Empty(Rng* rng) {
  return Frame(rng, [](cv::Mat*) {});
}

class Background : public ::testing::Test {
 protected:
  BackgroundModel Learnt(const BackgroundConfig& config = {}) {
    std::vector<cv::Mat> frames;
    for (int i = 0; i < 20; ++i) frames.push_back(Empty(&rng_));
    return {frames, Pose::Identity(), config};
  }

  Rng rng_{1};
};

TEST_F(Background, ShowsWhatHasBeenPutThereLargestFirst) {
  const cv::Mat frame = Frame(&rng_, [](cv::Mat* image) {
    (*image)(cv::Rect(10, 10, 14, 12)).setTo(cv::Scalar(30, 60, 200));
    (*image)(cv::Rect(50, 30, 20, 18)).setTo(cv::Scalar(220, 220, 40));
  });
  const Foreground found = Learnt().Detect(frame, {}, kCamera, Pose::Identity());
  ASSERT_EQ(found.clusters.size(), 2U) << found.reason;
  EXPECT_EQ(found.reason, "");
  // Twice the blur's sigma beyond its edge, a thing of such contrast still shows.
  EXPECT_THAT(found.clusters[0].pixels.size(),
              testing::AllOf(testing::Ge(20U * 18U), testing::Le(24U * 22U)));
  EXPECT_THAT(found.clusters[1].pixels.size(),
              testing::AllOf(testing::Ge(14U * 12U), testing::Le(18U * 16U)));
  EXPECT_FALSE(found.clusters[0].touches_border);
  EXPECT_TRUE(found.clusters[0].points_C.empty());
}

TEST_F(Background, GivesClustersWithDepthTheirPoints) {
  const cv::Mat frame = Frame(&rng_, [](cv::Mat* image) {
    (*image)(cv::Rect(30, 20, 20, 20)).setTo(cv::Scalar(30, 60, 200));
  });
  const cv::Mat depth(kHeight, kWidth, CV_32FC1, 0.7F);
  const Foreground found = Learnt().Detect(frame, depth, kCamera, Pose::Identity());
  ASSERT_EQ(found.clusters.size(), 1U) << found.reason;
  EXPECT_EQ(found.clusters[0].points_C.size(), found.clusters[0].pixels.size());
  // The square's middle is the picture's: on the optical axis.
  EXPECT_LT((found.clusters[0].center_C - Eigen::Vector3d(0.0, 0.0, 0.7)).norm(), 0.004);
}

TEST_F(Background, TakesAShadowForNothingNew) {
  const cv::Mat frame = Frame(&rng_, [](cv::Mat* image) {
    cv::Mat shaded = (*image)(cv::Rect(5, 20, 25, 25));
    shaded *= 0.7;
  });
  const Foreground found = Learnt().Detect(frame, {}, kCamera, Pose::Identity());
  EXPECT_TRUE(found.clusters.empty());
  EXPECT_TRUE(found.reason.find("none of them 80 together") != std::string::npos) << found.reason;
}

TEST_F(Background, SaysThatItKnowsNothingOnceTheCameraHasMoved) {
  const BackgroundModel background = Learnt();
  Pose X_WC = Pose::Identity();
  X_WC.translation().x() = 0.05;
  const Foreground found = background.Detect(Empty(&rng_), {}, kCamera, X_WC);
  EXPECT_TRUE(found.clusters.empty());
  EXPECT_EQ(found.reason,
            "the camera has moved by 0.050 m and 0.00 deg since the background was learnt; learn "
            "it anew from here, or cut by depth");
}

TEST_F(Background, SaysThatTheLightHasChanged) {
  const cv::Mat dark(kHeight, kWidth, CV_8UC3, cv::Scalar(20, 20, 20));
  const Foreground found = Learnt().Detect(dark, {}, kCamera, Pose::Identity());
  EXPECT_TRUE(found.clusters.empty());
  EXPECT_EQ(found.reason,
            "100 % of the picture is new; the light has changed, or the background "
            "is another");
}

TEST_F(Background, SaysTheSameOfTheSamePictureAgain) {
  const BackgroundModel background = Learnt();
  const cv::Mat frame = Frame(&rng_, [](cv::Mat* image) {
    (*image)(cv::Rect(10, 10, 20, 20)).setTo(cv::Scalar(30, 60, 200));
  });
  const Foreground first = background.Detect(frame, {}, kCamera, Pose::Identity());
  for (int i = 0; i < 50; ++i) background.Detect(frame, {}, kCamera, Pose::Identity());
  const Foreground again = background.Detect(frame, {}, kCamera, Pose::Identity());
  ASSERT_EQ(again.clusters.size(), 1U);
  EXPECT_EQ(again.clusters[0].pixels, first.clusters[0].pixels);
}

TEST_F(Background, RefusesWhatItCannotLearnFrom) {
  EXPECT_THROWS(BackgroundModel({Empty(&rng_)}, Pose::Identity()), InvalidArgument,
                "a background learnt from 1 frames");
  EXPECT_THROWS(BackgroundModel({Empty(&rng_), cv::Mat(10, 10, CV_8UC3)}, Pose::Identity()),
                InvalidArgument,
                "a picture of 10 x 10 pixels of type 16 for a background of 80 x 60");
  BackgroundConfig config;
  config.median_px = 4;
  EXPECT_THROWS(config.Validate(), ConfigError, "median_px = 4 must be odd");
  config = {};
  config.min_shadow = -1.0;
  EXPECT_THROWS(config.Validate(), ConfigError, "min_shadow = -1 must lie in 0..1");
}

}  // namespace
}  // namespace secondlook::perception
