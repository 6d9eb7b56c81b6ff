#include "apps/model_picture.h"

#include <gtest/gtest.h>

namespace secondlook::apps {
namespace {

TEST(DrawModel, ShowsTheWholeModelInItsColoursOnWhite) {
  const geometry::Mesh box = geometry::MakeBox({0.1, 0.05, 0.2}, {1.0F, 0.0F, 0.0F});
  const cv::Mat picture = DrawModel(box, 64);
  ASSERT_EQ(picture.size(), cv::Size(64, 64));
  const cv::Vec3b middle = picture.at<cv::Vec3b>(32, 32);
  EXPECT_GT(middle[0], 90);
  EXPECT_EQ(middle[1], 0);
  EXPECT_EQ(middle[2], 0);
  int covered = 0;
  for (int i = 0; i < 64; ++i) {
    for (const cv::Vec3b& edge : {picture.at<cv::Vec3b>(0, i), picture.at<cv::Vec3b>(63, i),
                                  picture.at<cv::Vec3b>(i, 0), picture.at<cv::Vec3b>(i, 63)}) {
      EXPECT_EQ(edge, cv::Vec3b(255, 255, 255)) << "it is cut off";
    }
    for (int j = 0; j < 64; ++j) covered += picture.at<cv::Vec3b>(i, j)[1] == 0 ? 1 : 0;
  }
  EXPECT_GT(covered, 64 * 64 / 8);
}

}  // namespace
}  // namespace secondlook::apps
