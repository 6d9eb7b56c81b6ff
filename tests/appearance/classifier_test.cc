#include "lib/perception/appearance/classifier.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/rng.h"
#include "lib/perception/appearance/feature_classifier.h"
#include "lib/perception/appearance/network_classifier.h"
#include "tests/appearance/tiny_network.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::perception {
namespace {

namespace fs = std::filesystem;

/// A picture of one of three classes: red disks, green bars, a blue chequered field.
cv::Mat Draw(int label, Rng* rng) {
  cv::Mat image(48, 48, CV_8UC3, cv::Scalar(128, 128, 128));
  const int size = 5 + rng->Index(4);
  for (int v = rng->Index(5); v < 48; v += 2 * size) {
    for (int u = rng->Index(5); u < 48; u += 2 * size) {
      if (label == 0) cv::circle(image, {u, v}, size / 2, {220, 30, 30}, cv::FILLED);
      if (label == 1) cv::rectangle(image, cv::Rect(u, 0, size / 2, 48), {30, 220, 30}, cv::FILLED);
      if (label == 2) cv::rectangle(image, cv::Rect(u, v, size, size), {30, 30, 220}, cv::FILLED);
    }
  }
  cv::Mat noise(image.size(), CV_8UC3);
  for (int i = 0; i < 48 * 48; ++i) {
    for (int c = 0; c < 3; ++c) {
      noise.at<cv::Vec3b>(i / 48, i % 48)[c] = static_cast<std::uint8_t>(rng->Index(30));
    }
  }
  return image + noise;
}

TrainingSet DrawnSet(int per_class) {
  Rng rng(1);
  TrainingSet set{{"bars", "disks", "field"}, {}, {}, "fnv1a 1"};
  for (int label = 0; label < 3; ++label) {
    for (int i = 0; i < per_class; ++i) {
      set.images.push_back({fmt::format("{}/{}.png", label, i), label, Draw(label, &rng)});
    }
  }
  return set;
}

void WriteImage(const fs::path& path, const cv::Mat& image) {
  fs::create_directories(path.parent_path());
  cv::imwrite(path.string(), image);
}

void Ignore(const std::string&) {}

constexpr std::array kKinds{FeatureClassifierKind::kSvm, FeatureClassifierKind::kSvm2021,
                            FeatureClassifierKind::kForest};

class EachKind : public ::testing::TestWithParam<FeatureClassifierKind> {};

TEST_P(EachKind, TellsPicturesApartThatItHasNotSeen) {
  const auto classifier = FeatureClassifier::Train(GetParam(), DrawnSet(9), {}, Ignore);
  Rng rng(2);
  for (int label = 0; label < 3; ++label) {
    const std::vector<double> p = classifier->Classify(Draw(label, &rng));
    EXPECT_NEAR(std::accumulate(p.begin(), p.end(), 0.0), 1.0, 1e-12);
    EXPECT_EQ(std::max_element(p.begin(), p.begin() + 3) - p.begin(), label);
  }
  EXPECT_GT(classifier->held_out_accuracy(), 0.9);
}

TEST_P(EachKind, SaysTheSameWhenReadFromItsFile) {
  const TemporaryFolder folder;
  const auto classifier = FeatureClassifier::Train(GetParam(), DrawnSet(6), {}, Ignore);
  classifier->Save(folder / "model.yml");
  const std::unique_ptr<Classifier> read = LoadClassifier(folder / "model.yml");
  EXPECT_EQ(read->classes(), classifier->classes());
  EXPECT_EQ(ReadClassifierHeader(folder / "model.yml").training_hash, "fnv1a 1");
  EXPECT_EQ(ReadClassifierHeader(folder / "model.yml").images, 18);
  Rng rng(3);
  const cv::Mat image = Draw(1, &rng);
  const std::vector<double> expected = classifier->Classify(image);
  const std::vector<double> actual = read->Classify(image);
  for (std::size_t c = 0; c < expected.size(); ++c) EXPECT_NEAR(actual[c], expected[c], 1e-4);
}

TEST_P(EachKind, TakesImagesOnePixelWide) {
  const auto classifier = FeatureClassifier::Train(GetParam(), DrawnSet(6), {}, Ignore);
  const std::vector<double> p = classifier->Classify(cv::Mat(40, 1, CV_8UC3, cv::Scalar(1, 2, 3)));
  EXPECT_NEAR(std::accumulate(p.begin(), p.end(), 0.0), 1.0, 1e-12);
  EXPECT_THROWS(classifier->Classify(cv::Mat()), InvalidArgument, "an image of 0 x 0 pixels");
}

INSTANTIATE_TEST_SUITE_P(FeatureClassifier, EachKind, ::testing::ValuesIn(kKinds));

TEST(FeatureClassifier, HasTheClassUnknownWhereItsPaperHasIt) {
  const auto svm = FeatureClassifier::Train(FeatureClassifierKind::kSvm, DrawnSet(6), {}, Ignore);
  EXPECT_EQ(svm->classes().back(), kUnknownClass);
  EXPECT_EQ(svm->classes().size(), 4U);
}

TEST(FeatureClassifier, NeedsAnImageOfEveryClassInEachFold) {
  TrainingSet set = DrawnSet(6);
  set.images.erase(set.images.begin(), set.images.begin() + 5);
  EXPECT_THROWS(FeatureClassifier::Train(FeatureClassifierKind::kSvm, set, {}, Ignore), ConfigError,
                "class 'bars' has 1 images; 3 folds need at least as many");
  FeatureTrainingConfig config;
  config.folds = 1;
  EXPECT_THROWS(FeatureClassifier::Train(FeatureClassifierKind::kSvm, set, config, Ignore),
                ConfigError, "folds = 1");
}

ClassifierHeader ColorsHeader() {
  return {"backbone", {"blue", "green", "red"}, "fnv1a 2", 9, 0.5};
}

TEST(NetworkClassifier, RunsTheNetworkOfItsModelFile) {
  const TemporaryFolder folder;
  WriteFile(folder / "net.onnx", TinyNetwork());
  WriteNetworkFile(folder / "model.yml", ColorsHeader(), folder / "net.onnx", 8);
  const std::unique_ptr<Classifier> classifier = LoadClassifier(folder / "model.yml");
  // RGB means 100, 50 and 0 make the logits 10, 5 and 0.
  const std::vector<double> p =
      classifier->Classify(cv::Mat(20, 9, CV_8UC3, cv::Scalar(100, 50, 0)));
  const double sum = 1.0 + std::exp(-5.0) + std::exp(-10.0);
  EXPECT_NEAR(p[0], 1.0 / sum, 1e-5);
  EXPECT_NEAR(p[1], std::exp(-5.0) / sum, 1e-5);
  EXPECT_EQ(classifier->held_out_accuracy(), 0.5);
}

TEST(NetworkClassifier, SaysTheSameOfAnImageAndItsMirrorImage) {
  const TemporaryFolder folder;
  WriteFile(folder / "net.onnx", LeftOrRightNetwork());
  WriteNetworkFile(folder / "model.yml", {"cnn1", {"left", "right"}, "fnv1a 3", 2, 0.5},
                   folder / "net.onnx", 2);
  const std::unique_ptr<Classifier> classifier = LoadClassifier(folder / "model.yml");
  cv::Mat image(2, 2, CV_8UC3, cv::Scalar(0, 0, 0));
  image.at<cv::Vec3b>(0, 0) = {100, 0, 0};  // by itself, of class "left" with 0.99995
  cv::Mat mirrored;
  cv::flip(image, mirrored, 1);
  EXPECT_NEAR(classifier->Classify(image)[0], 0.5, 1e-6);
  EXPECT_NEAR(classifier->Classify(mirrored)[0], 0.5, 1e-6);
}

TEST(NetworkClassifier, TakesImagesOnePixelWide) {
  const TemporaryFolder folder;
  WriteFile(folder / "net.onnx", TinyNetwork());
  WriteNetworkFile(folder / "model.yml", ColorsHeader(), folder / "net.onnx", 8);
  const std::unique_ptr<Classifier> classifier = LoadClassifier(folder / "model.yml");
  EXPECT_GT(classifier->Classify(cv::Mat(40, 1, CV_8UC3, cv::Scalar(0, 0, 100)))[2], 0.99);
  EXPECT_THROWS(classifier->Classify(cv::Mat()), InvalidArgument, "an image of 0 x 0 pixels");
}

TEST(NetworkClassifier, RefusesANetworkWhoseWeightsAreNoNumbers) {
  const TemporaryFolder folder;
  std::string network = TinyNetwork();
  const std::string tenth = FromHex("cdcccc3d");
  network.replace(network.find(tenth), tenth.size(), FromHex("0000c07f"));  // NaN
  WriteFile(folder / "net.onnx", network);
  WriteNetworkFile(folder / "model.yml", ColorsHeader(), folder / "net.onnx", 8);
  EXPECT_THROWS(LoadClassifier(folder / "model.yml"), ConfigError,
                "gives class 1 the probability nan; train it anew");
}

TEST(NetworkClassifier, RefusesAnotherNetworkThanItsOwn) {
  const TemporaryFolder folder;
  WriteFile(folder / "net.onnx", TinyNetwork());
  WriteNetworkFile(folder / "model.yml", ColorsHeader(), folder / "net.onnx", 8);
  WriteFile(folder / "net.onnx", "something else");
  EXPECT_THROWS(LoadClassifier(folder / "model.yml"), ConfigError,
                "net.onnx: is not the network that the model file was made with");
  WriteNetworkFile(folder / "model.yml", ColorsHeader(), folder / "net.onnx", 8);
  EXPECT_THROWS(LoadClassifier(folder / "model.yml"), ConfigError, "cannot be read as ONNX");
  WriteFile(folder / "net.onnx", TinyNetwork());
  ClassifierHeader two = ColorsHeader();
  two.classes.pop_back();
  WriteNetworkFile(folder / "model.yml", two, folder / "net.onnx", 8);
  EXPECT_THROWS(LoadClassifier(folder / "model.yml"), ConfigError,
                "tells of 3 classes, its model file of 2");
}

TEST(LoadClassifier, NamesAFileThatIsNoModel) {
  const TemporaryFolder folder;
  EXPECT_THROWS(LoadClassifier(folder / "none.yml"), ConfigError, "none.yml");
  WriteFile(folder / "text.yml", "hello\n");
  EXPECT_THROWS(LoadClassifier(folder / "text.yml"), ConfigError,
                "text.yml: no model file of a classifier");
  WriteFile(folder / "old.yml", "%YAML:1.0\n---\nsecond_look_classifier: 7\n");
  EXPECT_THROWS(LoadClassifier(folder / "old.yml"), ConfigError,
                "a model file of version 7, this program reads 1");
  WriteFile(folder / "kind.yml",
            "%YAML:1.0\n---\nsecond_look_classifier: 1\nkind: oracle\nclasses: [ a, b ]\n");
  EXPECT_THROWS(LoadClassifier(folder / "kind.yml"), ConfigError, "a classifier of kind 'oracle'");
  WriteFile(folder / "one.yml",
            "%YAML:1.0\n---\nsecond_look_classifier: 1\nkind: svm\nclasses: [ a ]\n");
  EXPECT_THROWS(LoadClassifier(folder / "one.yml"), ConfigError,
                "has 1 classes, 1 of them different");
}

TEST(CheckClasses, NamesBothListsWhenTheyDiffer) {
  const TemporaryFolder folder;
  WriteFile(folder / "net.onnx", TinyNetwork());
  WriteNetworkFile(folder / "model.yml", ColorsHeader(), folder / "net.onnx", 8);
  const auto classifier = LoadClassifier(folder / "model.yml");
  EXPECT_NO_THROW(CheckClasses(*classifier, {"red", "green", "blue"}, "model.yml"));
  EXPECT_THROWS(CheckClasses(*classifier, {"red", "cup"}, "model.yml"), ConfigError,
                "model.yml: tells of blue, green, red; needed are cup, red");
}

TEST(ReadTrainingSet, TakesASubFolderForEachClass) {
  const TemporaryFolder folder;
  WriteImage(folder / "cup/1.png", cv::Mat(4, 5, CV_8UC3, cv::Scalar(0, 0, 255)));  // BGR
  WriteImage(folder / "bowl/1.png", cv::Mat(4, 5, CV_8UC3, cv::Scalar(255, 0, 0)));
  WriteImage(folder / "bowl/2.png", cv::Mat(4, 5, CV_8UC3, cv::Scalar(255, 0, 0)));
  const TrainingSet set = ReadTrainingSet(folder.path());
  EXPECT_EQ(set.classes, (std::vector<std::string>{"bowl", "cup"}));
  ASSERT_EQ(set.images.size(), 3U);
  EXPECT_EQ(set.images[2].label, 1);
  EXPECT_EQ(set.images[2].image.at<cv::Vec3b>(0, 0), cv::Vec3b(255, 0, 0));
  WriteImage(folder / "cup/1.png", cv::Mat(4, 5, CV_8UC3, cv::Scalar(0, 0, 254)));
  EXPECT_NE(ReadTrainingSet(folder.path()).hash, set.hash);
}

TEST(ReadTrainingSet, LeavesOutAJpegThatEndsTooEarlyAndSaysSo) {
  const TemporaryFolder folder;
  WriteImage(folder / "bowl/1.jpg", cv::Mat(40, 50, CV_8UC3, cv::Scalar(255, 0, 0)));
  WriteImage(folder / "cup/1.jpg", cv::Mat(40, 50, CV_8UC3, cv::Scalar(255, 0, 0)));
  const std::string whole = ReadFile(folder / "cup/1.jpg");
  WriteFile(folder / "cup/2.jpg", whole.substr(0, whole.size() - 20));
  const TrainingSet set = ReadTrainingSet(folder.path());
  EXPECT_EQ(set.images.size(), 2U);
  ASSERT_EQ(set.left_out.size(), 1U);
  EXPECT_THAT(set.left_out[0], ::testing::HasSubstr("2.jpg: a JPEG without its end"));
}

TEST(ReadTrainingSet, NamesFoldersThatCannotBeLearntFrom) {
  const TemporaryFolder folder;
  EXPECT_THROWS(ReadTrainingSet(folder / "none"), ConfigError, "none: no such folder");
  WriteImage(folder / "cup/1.png", cv::Mat(4, 5, CV_8UC3));
  EXPECT_THROWS(ReadTrainingSet(folder.path()), ConfigError, "has 1 classes");
  fs::create_directories(folder / "bowl");
  EXPECT_THROWS(ReadTrainingSet(folder.path()), ConfigError, "bowl: the class has no image");
}

TEST(FitPlatt, FindsTheSigmoidThatTheScoresWereDrawnFrom) {
  Rng rng(4);
  const PlattSigmoid truth{-2.0, 0.5};
  std::vector<double> scores;
  std::vector<bool> positive;
  for (int i = 0; i < 20000; ++i) {
    scores.push_back(rng.Uniform(-2.0, 2.0));
    positive.push_back(rng.Uniform(0.0, 1.0) < truth(scores.back()));
  }
  const PlattSigmoid fit = FitPlatt(scores, positive);
  EXPECT_NEAR(fit.a, truth.a, 0.1);
  EXPECT_NEAR(fit.b, truth.b, 0.1);
  EXPECT_THROWS(FitPlatt({1.0, 2.0}, {true, true}), InvalidArgument, "2 positive and 0 negative");
}

}  // namespace
}  // namespace secondlook::perception
