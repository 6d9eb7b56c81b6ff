#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "lib/common/files.h"
#include "lib/perception/appearance/classifier.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace secondlook {
namespace {

using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::RunProgram;

class Train : public ::testing::Test {
 protected:
  Train() {
    for (int i = 0; i < 6; ++i) {
      WriteImage("cup", i, cv::Scalar(30 + i, 30, 200));
      WriteImage("bowl", i, cv::Scalar(200 - i, 30, 30));
    }
  }

  void WriteImage(const std::string& label, int number, const cv::Scalar& bgr) const {
    std::filesystem::create_directories(folder_ / "images" / label);
    cv::Mat image(30, 40, CV_8UC3, bgr);
    image(cv::Rect(number, 5, 10, 10)).setTo(cv::Scalar::all(90 + 10 * number));
    cv::imwrite((folder_ / "images" / label / (std::to_string(number) + ".png")).string(), image);
  }

  ProgramResult Run(const std::string& classifier) const {
    return RunProgram({"train", "--images", (folder_ / "images").string(), "--classifier",
                       classifier, "--out", Model().string()});
  }

  std::filesystem::path Model() const { return folder_ / "model.yml"; }

  TemporaryFolder folder_;
};

TEST_F(Train, LeavesAModelFileAndSaysHowGoodItIs) {
  const ProgramResult result = Run("svm");
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("svm, 3 classes, 12 images (fnv1a "));
  EXPECT_EQ(perception::LoadClassifier(Model())->classes(),
            (std::vector<std::string>{"bowl", "cup", "unknown"}));
}

TEST_F(Train, NamesAFileThatIsNoImageAndGoesOn) {
  WriteFile(folder_ / "images" / "cup" / "notes.txt", "these are cups");
  const ProgramResult result = Run("svm");
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.err, HasSubstr("left out: "));
  EXPECT_THAT(result.err, HasSubstr("notes.txt: no image"));
}

TEST_F(Train, SaysWhatIsWrongWithTheImages) {
  std::filesystem::remove_all(folder_ / "images" / "bowl");
  const ProgramResult one = Run("svm");
  EXPECT_EQ(one.status, 2);
  EXPECT_THAT(one.err, HasSubstr("has 1 classes; a classifier needs at least two"));
  EXPECT_EQ(Run("oracle").status, 2);
}

TEST_F(Train, NamesTheClassThatHasTooFewImagesForANetwork) {
  for (int i = 1; i < 6; ++i) {
    std::filesystem::remove(folder_ / "images" / "bowl" / (std::to_string(i) + ".png"));
  }
  const ProgramResult result = Run("cnn1");
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(
      result.err,
      HasSubstr("class 'bowl' has 1 image; a network needs at least 2, as one is kept out"));
}

TEST_F(Train, SaysWhatToInstallWhereThereIsNoPython) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder_.path().c_str(), 1);  // with nothing in it
  const ProgramResult result = Run("cnn1");
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, HasSubstr("tools/train_network/run failed; it needs the Debian packages "
                                    "python3 and python3-venv"));
  EXPECT_FALSE(std::filesystem::exists(Model()));
}

}  // namespace
}  // namespace secondlook
