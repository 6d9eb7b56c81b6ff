#include "apps/rgbd_images.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::apps {
namespace {

class Images : public ::testing::Test {
 protected:
  std::string Write(const char* name, const cv::Mat& image) {
    const std::string file = (folder_ / name).string();
    cv::imwrite(file, image);
    return file;
  }

  TemporaryFolder folder_;
};

TEST_F(Images, DepthComesInMetresAndWithoutMeasurementAsNaN) {
  cv::Mat raw(4, 6, CV_16UC1, cv::Scalar(9500));
  raw.at<std::uint16_t>(1, 2) = 0;
  const cv::Mat depth = ReadDepthImage(Write("depth.png", raw), 0.0001);
  EXPECT_FLOAT_EQ(depth.at<float>(0, 0), 0.95F);
  EXPECT_TRUE(std::isnan(depth.at<float>(1, 2)));
}

TEST_F(Images, RefuseADepthInAnotherUnit) {
  const std::string file = Write("depth.png", cv::Mat(4, 6, CV_16UC1, cv::Scalar(850)));
  EXPECT_NO_THROW(ReadDepthImage(file, 0.001));
  EXPECT_THROWS(ReadDepthImage(file, 1.0), InvalidArgument,
                "with --depth-unit 1 the median depth is 850 m, and no table is that far");
  EXPECT_THROWS(ReadDepthImage(file, 1e-5), InvalidArgument, "the median depth is 0.0085 m");
  EXPECT_THROWS(ReadDepthImage(file, 0.0), InvalidArgument, "--depth-unit 0: must be the metres");
}

TEST_F(Images, RefuseADepthImageThatHoldsNone) {
  EXPECT_THROWS(ReadDepthImage(Write("zero.png", cv::Mat::zeros(4, 6, CV_16UC1)), 0.001),
                ConfigError, "zero.png: no pixel has a depth");
  EXPECT_THROWS(ReadDepthImage(Write("rgb.png", cv::Mat::ones(4, 6, CV_8UC3)), 0.001), ConfigError,
                "rgb.png: has 3 channels of 1 bytes");
  EXPECT_THROWS(ReadDepthImage("/no/such.png", 0.001), ConfigError, "/no/such.png: no such file");
  WriteFile(folder_ / "text.png", "no image");
  EXPECT_THROWS(ReadDepthImage(folder_ / "text.png", 0.001), ConfigError,
                "text.png: is no image that can be read");
}

TEST_F(Images, RefuseAColourImageOfAnotherSize) {
  const std::string file = Write("color.png", cv::Mat::ones(8, 6, CV_8UC3));
  EXPECT_THROWS(ReadColorImage(file, cv::Mat::ones(4, 6, CV_32FC1)), InvalidArgument,
                "color.png: is 6 x 8, the depth image 6 x 4: both must be registered");
}

}  // namespace
}  // namespace secondlook::apps
