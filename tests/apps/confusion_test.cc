#include "apps/experiments/confusion.h"

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/temporary_folder.h"

namespace secondlook::apps {
namespace {

/// Of four cups three are right and one is called a tin; of two tins one is missed; something that
/// is nothing is called a tin.
ConfusionMatrix CupsAndTins() {
  ConfusionMatrix matrix(2);
  for (int i = 0; i < 3; ++i) matrix.Add(0, 0);
  matrix.Add(0, 1);
  matrix.Add(1, 1);
  matrix.Add(1, ConfusionMatrix::kBackground);
  matrix.Add(ConfusionMatrix::kBackground, 1);
  return matrix;
}

TEST(ConfusionMatrix, CountsMissesAndFalseDetectionsAsThePaperDoes) {
  const ConfusionMatrix matrix = CupsAndTins();
  EXPECT_DOUBLE_EQ(matrix.Accuracy(), 4.0 / 6.0) << "true detections of all things that are there";
  EXPECT_DOUBLE_EQ(matrix.Recall(), (3.0 / 4.0 + 1.0 / 2.0) / 2.0);
  EXPECT_DOUBLE_EQ(matrix.Precision(), (3.0 / 3.0 + 1.0 / 3.0) / 2.0) << "the false tin counts";
  EXPECT_DOUBLE_EQ(matrix.F1(), 2.0 * 0.625 * (2.0 / 3.0) / (0.625 + 2.0 / 3.0));
  EXPECT_DOUBLE_EQ(matrix.FalseDetections(), 1.0);
}

TEST(ConfusionMatrix, AddsUp) {
  ConfusionMatrix sum = CupsAndTins();
  sum += CupsAndTins();
  EXPECT_DOUBLE_EQ(sum.counts()(0, 0), 6.0);
  EXPECT_DOUBLE_EQ(sum.Accuracy(), CupsAndTins().Accuracy());
}

TEST(ConfusionMatrix, IsAPictureWithACellForEachPair) {
  const TemporaryFolder folder;
  WritePicture(CupsAndTins(), {"cup", "tin"}, "plain", folder / "matrix.png");
  const cv::Mat picture = cv::imread((folder / "matrix.png").string());
  ASSERT_FALSE(picture.empty());
  // Three of four cups are right: the cell is darker than that of the one that is not.
  const auto shade = [&](int row, int column) {
    return picture.at<cv::Vec3b>(150 + 56 * row + 4, 150 + 56 * column + 4)[2];
  };
  EXPECT_LT(shade(0, 0), shade(0, 1));
  EXPECT_LT(shade(0, 1), shade(0, 2)) << "nothing is white";
}

}  // namespace
}  // namespace secondlook::apps
