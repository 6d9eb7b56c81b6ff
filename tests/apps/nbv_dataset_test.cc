#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/experiments/experiment.h"
#include "apps/experiments/nbv_distortion.h"
#include "apps/experiments/nbv_experience.h"
#include "apps/experiments/nbv_summary.h"
#include "apps/experiments/npy.h"
#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/perception/appearance/network_classifier.h"
#include "tests/appearance/tiny_network.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::apps {
namespace {

namespace fs = std::filesystem;
using planning::ObjectCrop;

/// A NumPy file as numpy.save() writes it.
std::string Npy(const cv::Mat& matrix, const std::string& type = "<f4") {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}, {}), }}",
                                   type, matrix.rows, matrix.cols);
  header.resize(117, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += std::string("\x76\x00", 2) + header;
  bytes.append(reinterpret_cast<const char*>(matrix.data), matrix.total() * sizeof(float));
  return bytes;
}

TEST(ReadNpy, ReadsRowsOfFloats) {
  const TemporaryFolder folder;
  const cv::Mat written = (cv::Mat_<float>(2, 3) << 1, 2, 3, 4, 5, 6.5);
  WriteFile(folder / "a.npy", Npy(written));
  EXPECT_EQ(cv::countNonZero(ReadNpy(folder / "a.npy") != written), 0);
}

TEST(ReadNpy, NamesFilesThatItCannotRead) {
  const TemporaryFolder folder;
  const cv::Mat some = cv::Mat::ones(2, 3, CV_32FC1);
  WriteFile(folder / "text.npy", "hello, this is no matrix");
  EXPECT_THROWS(ReadNpy(folder / "text.npy"), ConfigError, "text.npy: no NumPy file of version 1");
  WriteFile(folder / "double.npy", Npy(some, "<f8"));
  EXPECT_THROWS(ReadNpy(folder / "double.npy"), ConfigError, "no matrix of 32-bit floats");
  WriteFile(folder / "short.npy", Npy(some).substr(0, 140));
  EXPECT_THROWS(ReadNpy(folder / "short.npy"), ConfigError, "12 bytes of data, its shape needs 24");
}

ObjectCrop Plain(int level, float depth) {
  return {cv::Mat(20, 10, CV_8UC3, cv::Scalar::all(level)), cv::Mat(20, 10, CV_32FC1, depth),
          525.0};
}

TEST(Distorted, BlanksHalfOfTheImageAndGivesItTheMeanDepth) {
  ObjectCrop crop = Plain(100, 1.0F);
  crop.depth(cv::Rect(0, 10, 10, 10)).setTo(2.0);
  crop.depth.at<float>(0, 0) = 0.0F;  // unknown: 99 x 1 m and 100 x 2 m are known
  Rng rng(1);
  const ObjectCrop top = Distorted(crop, 1, Plain(7, 1.0F), &rng);
  EXPECT_EQ(top.color.at<cv::Vec3b>(9, 5), cv::Vec3b::all(255));
  EXPECT_EQ(top.color.at<cv::Vec3b>(10, 5), cv::Vec3b::all(100));
  EXPECT_NEAR(top.depth.at<float>(9, 5), 299.0 / 199.0, 1e-5);
  EXPECT_EQ(top.depth.at<float>(10, 5), 2.0F);
  const ObjectCrop right = Distorted(crop, 4, Plain(7, 1.0F), &rng);
  EXPECT_EQ(right.color.at<cv::Vec3b>(3, 5), cv::Vec3b::all(0));
  EXPECT_EQ(right.color.at<cv::Vec3b>(3, 4), cv::Vec3b::all(100));
}

TEST(Distorted, LaysAnotherObjectOverSixtyPercentOfLengthAndWidth) {
  Rng rng(1);
  for (int corner = 0; corner < 4; ++corner) {
    const ObjectCrop covered = Distorted(Plain(100, 1.0F), 7 + corner, Plain(7, 0.5F), &rng);
    cv::Mat gray;
    cv::extractChannel(covered.color, gray, 0);
    EXPECT_EQ(cv::countNonZero(gray == 7), 12 * 6);
    EXPECT_EQ(cv::countNonZero(covered.depth == 0.5F), 12 * 6);
    EXPECT_EQ(gray.at<std::uint8_t>(corner < 2 ? 0 : 19, corner % 2 == 0 ? 0 : 9), 7);
  }
}

TEST(Distorted, ClipsWhatBecomesTooBrightOrTooDark) {
  Rng rng(1);
  const ObjectCrop other = Plain(7, 1.0F);
  const auto level = [&](int from, int distortion) {
    return Distorted(Plain(from, 1.0F), distortion, other, &rng).color.at<cv::Vec3b>(0, 0)[0];
  };
  EXPECT_EQ(level(200, 13), 255);
  EXPECT_EQ(level(50, 13), 200);
  EXPECT_EQ(level(100, 14), 0);
  EXPECT_EQ(level(200, 14), 50);
}

TEST(Distorted, IsTheSameForTheSameSeed) {
  Rng a(5);
  Rng b(5);
  const ObjectCrop first = Distorted(Plain(100, 1.0F), 6, Plain(7, 1.0F), &a);
  const ObjectCrop second = Distorted(Plain(100, 1.0F), 6, Plain(7, 1.0F), &b);
  EXPECT_EQ(cv::norm(first.color, second.color), 0.0);
  EXPECT_GT(cv::norm(first.color, Plain(100, 1.0F).color), 0.0);
}

/// Two classes; the first view says the wrong one, the view from the upper left the right one with
/// certainty, and all others agree with the first view.
NbvSet OneGoodSide(int truth) {
  const std::vector<double> wrong = truth == 0 ? std::vector{0.25, 0.75} : std::vector{0.75, 0.25};
  NbvSet set;
  set.truth = truth;
  set.sides.fill(wrong);
  set.sides[0] = truth == 0 ? std::vector{0.99, 0.01} : std::vector{0.01, 0.99};
  NbvCase& one = set.cases.emplace_back();
  one.front = wrong;
  for (std::size_t s = 0; s < kSideCount; ++s) {
    one.sides[s].tile = kSides[s];
    one.sides[s].scores.fill(0.0);
    // Variance finds the good side, entropy the last one.
    one.sides[s].scores[0] = s == 0 ? 1.0 : 0.0;
    one.sides[s].scores[static_cast<int>(planning::Criterion::kEntropy)] = static_cast<double>(s);
  }
  return set;
}

double Value(const std::vector<Row>& rows, const std::string& metric) {
  for (const Row& row : rows) {
    if (row.metric == metric) return row.estimate.value;
  }
  ADD_FAILURE() << "no row '" << metric << "'";
  return 0.0;
}

TEST(SummariseNbv, TellsWaysToChooseTheSideApart) {
  const std::vector<NbvSet> sets{OneGoodSide(0), OneGoodSide(1)};
  const std::vector<Row> rows = SummariseNbv(sets, {{"cup", "mug"}, 0.9});
  for (const std::string rule : {"naive Bayes", "averaging", "belief masses"}) {
    const auto accuracy = [&](const std::string& chooser) {
      return Value(rows, fmt::format("accuracy, {}: {}", rule, chooser));
    };
    EXPECT_EQ(accuracy("single view"), 0.0);
    EXPECT_NEAR(accuracy("random side"), 0.2, 1e-12);
    EXPECT_EQ(accuracy("always upper left"), 1.0);
    EXPECT_EQ(accuracy("always top"), 0.0);
    EXPECT_EQ(accuracy("variance"), 1.0);
    EXPECT_EQ(accuracy("entropy"), 0.0);
    EXPECT_EQ(accuracy("oracle"), 1.0);
  }
  EXPECT_NEAR(Value(rows, "share of the gap from random to oracle: variance"), 1.0, 1e-12);
  EXPECT_NEAR(Value(rows, "share of the gap from random to oracle: entropy"), -0.25, 1e-12);
}

TEST(SummariseNbv, LooksTwiceOnlyBelowTheGate) {
  const std::vector<Row> rows = SummariseNbv({OneGoodSide(0)}, {{"cup", "mug"}, 0.9});
  // The first view's ratio is 3: the gate of 3 lets it pass, that of 5 does not.
  EXPECT_EQ(Value(rows, "gate 3: share of second looks"), 0.0);
  EXPECT_EQ(Value(rows, "gate 5: share of second looks"), 1.0);
  EXPECT_EQ(Value(rows, "gate 3: accuracy, paper's vote"), 0.0);
  EXPECT_EQ(Value(rows, "gate 5: accuracy, paper's vote"), 1.0);
}

TEST(SummariseNbv, MeasuresWhatAConfusionMatrixByHandGives) {
  // Single views: both cups are called mugs with 0.75 and the mug a cup, likewise.
  const std::vector<Row> rows =
      SummariseNbv({OneGoodSide(0), OneGoodSide(0), OneGoodSide(1)}, {{"cup", "mug"}, 0.9});
  EXPECT_EQ(Value(rows, "macro recall: single view"), 0.0);
  EXPECT_EQ(Value(rows, "macro precision: single view"), 0.0);
  EXPECT_NEAR(Value(rows, "expected calibration error: single view"), 0.75, 1e-12);
}

TEST(SummariseNbv, TellsTrueFromOtherClassesByTheAreaUnderTheRocCurve) {
  const std::vector<Row> rows =
      SummariseNbv({OneGoodSide(0), OneGoodSide(1)}, {{"cup", "mug"}, 0.9});
  const auto area = [&](const std::string& of) {
    return Value(rows, "area under the micro-averaged ROC curve: " + of);
  };
  EXPECT_NEAR(area("single view"), 0.0, 1e-12);   // true classes at 0.25, others at 0.75
  EXPECT_NEAR(area("paper's vote"), 1.0, 1e-12);  // true classes at 0.97
  // A random side: of the true classes a fifth is above all others, of the others a fifth below all
  // true ones, and nothing in between.
  EXPECT_NEAR(area("random side"), 1.0 - 0.8 * 0.8, 1e-12);
}

TEST(SummariseNbv, LearnsWithTheOtherBlocksAlone) {
  NbvSet first = OneGoodSide(0);
  NbvSet second = OneGoodSide(1);
  second.block = 1;
  const std::vector<Row> rows = SummariseNbv({first, second}, {{"cup", "mug"}, 0.9});
  EXPECT_EQ(Value(rows, "accuracy, naive Bayes: learned"), 1.0);
  const std::vector<Row> one_block = SummariseNbv({first, first}, {{"cup", "mug"}, 0.9});
  EXPECT_TRUE(std::none_of(one_block.begin(), one_block.end(), [](const Row& row) {
    return row.metric == "accuracy, naive Bayes: learned";
  }));
}

TEST(Experience, ExpectsWhatLoggedViewsOfEachClassMakeOfTheFirst) {
  // From the upper left a cup was seen as a cup with 0.8, from all other sides it told nothing.
  NbvSet cup = OneGoodSide(0);
  cup.sides.fill({0.5, 0.5});
  cup.sides[0] = {0.8, 0.2};
  const std::vector<NbvSet> sets{cup};
  const NbvClassifier classifier{{"cup", "mug"}, 0.9};
  const nbv::Decisions decisions(sets, classifier);
  const nbv::Experience experience(decisions, [](int) { return true; });
  // A cup with 0.6: 0.6 * 0.8 / (0.6 * 0.8 + 0.4 * 0.2) = 0.857 from there. A mug was never seen.
  const Eigen::VectorXd expected = experience.Expected({0.6, 0.4});
  EXPECT_NEAR(expected[0], 0.6 * 0.48 / 0.56 + 0.4 * 0.4, 1e-12);
  for (int side = 1; side < 5; ++side) {
    EXPECT_NEAR(expected[side], 0.6 * 0.6 + 0.4 * 0.4, 1e-12) << side;
  }
}

TEST(ExperienceOfOthers, KnowsNothingOfTheCasesOwnBlockNorOfTheTested) {
  std::vector<NbvSet> sets(3, OneGoodSide(0));
  for (int i = 0; i < 3; ++i) {
    sets[i].block = i;
    sets[i].sides.fill({0.5, 0.5});
  }
  sets[0].sides[0] = {0.9, 0.1};
  sets[1].sides[1] = {0.9, 0.1};
  const NbvClassifier classifier{{"cup", "mug"}, 0.9};
  const nbv::Decisions decisions(sets, classifier);
  const nbv::ExperienceOfOthers experience(decisions);
  Eigen::Index best = -1;
  experience.Expected(0, 0, 2).maxCoeff(&best);
  EXPECT_EQ(best, 1);  // by block 1 alone
  experience.Expected(1, 0, 2).maxCoeff(&best);
  EXPECT_EQ(best, 0);  // by block 0 alone
  const Eigen::VectorXd none = experience.Expected(0, 0, 1);
  EXPECT_NEAR(none.maxCoeff() - none.minCoeff(), 0.0, 1e-12);  // by block 2, which saw nothing
}

TEST(ExperienceOfOthers, PromisesMoreWhereTheFirstViewIsUnsure) {
  std::vector<NbvSet> sets(2, OneGoodSide(0));
  sets[1].block = 1;
  sets[0].cases.front().front = {0.5, 0.5};
  sets[0].cases.push_back(sets[0].cases.front());
  sets[0].cases.back().front = {0.95, 0.05};
  const NbvClassifier classifier{{"cup", "mug"}, 0.9};
  const nbv::Decisions decisions(sets, classifier);
  const nbv::ExperienceOfOthers experience(decisions);
  // The best side says cup with 0.99, and nothing is known of mugs.
  EXPECT_NEAR(experience.Promise(0, 0), 0.5 * 0.99 + 0.5 * 0.5 - 0.5, 1e-12);
  EXPECT_LT(experience.Promise(0, 1), experience.Promise(0, 0));
}

/// Two sets of the data set's form, of plain colours, and a classifier of these.
class NbvDataset : public ::testing::Test {
 protected:
  NbvDataset() {
    WriteFile(folder_ / "net.onnx", perception::TinyNetwork());
    perception::WriteNetworkFile(folder_ / "model.yml",
                                 {"backbone", {"Red", "Green", "Blue"}, "fnv1a 1", 3, 0.9},
                                 folder_ / "net.onnx", 8);
    WriteSet(0, "Red", {40, 60, 200});  // BGR
    WriteSet(41, "Blue", {200, 60, 40});
    options_.data = folder_.path().string();
    options_.classifier = (folder_ / "model.yml").string();
    options_.json = (folder_ / "result.json").string();
    options_.trials = 1000;
  }

  void WriteSet(int number, const std::string& label, const cv::Scalar& bgr) {
    const fs::path set = folder_.path() / "Test_Files" / std::to_string(number);
    fs::create_directories(set);
    WriteFile(set / "label.txt", label + "\r\n");
    for (const std::string name : {"1", "2", "3", "4", "5", "Front_Down", "Front_Up"}) {
      cv::imwrite((set / (name + ".jpg")).string(), cv::Mat(24, 30, CV_8UC3, bgr));
      cv::Mat depth(24, 30, CV_32FC1, cv::Scalar(1.0));
      depth(cv::Rect(5, 5, 20, 15)).setTo(0.8);
      WriteFile(set / (name + ".npy"), Npy(depth));
    }
  }

  nlohmann::json Result() const { return nlohmann::json::parse(ReadFile(options_.json)); }

  TemporaryFolder folder_;
  ExperimentOptions options_;
};

TEST_F(NbvDataset, MeasuresWhateverSetsThereAre) {
  RunNbvDatasetExperiment(options_);
  const nlohmann::json result = Result();
  EXPECT_EQ(result["trials"], 2);
  EXPECT_EQ(result["details"][0]["cases"].size(), 30U);
  for (const nlohmann::json& row : result["rows"]) {
    if (row["metric"] == "accuracy, naive Bayes: random side") {
      EXPECT_GT(row["value"].get<double>(), 0.9);
    }
  }
}

TEST_F(NbvDataset, GivesTheSameForTheSameSeedAlsoMirrored) {
  options_.mirror = true;
  options_.threads = 1;
  RunNbvDatasetExperiment(options_);
  nlohmann::json first = Result();
  options_.threads = 2;
  options_.report = (folder_ / "plots").string();
  RunNbvDatasetExperiment(options_);
  EXPECT_EQ(Result()["details"], first["details"]);
  EXPECT_EQ(cv::imread((folder_ / "plots" / "roc.png").string()).size(), cv::Size(640, 480));
  EXPECT_EQ(cv::imread((folder_ / "plots" / "second_looks.png").string()).size(),
            cv::Size(640, 480));
}

TEST_F(NbvDataset, NamesTheViewThatCannotBeRead) {
  const fs::path side = folder_.path() / "Test_Files" / "41" / "3.jpg";
  const std::string whole = ReadFile(side);
  WriteFile(side, whole.substr(0, whole.size() - 20));
  EXPECT_THROWS(RunNbvDatasetExperiment(options_), ConfigError, "41/3.jpg: a JPEG without its end");
  WriteFile(side, whole);
  WriteFile(folder_.path() / "Test_Files" / "41" / "Front_Up.npy",
            Npy(cv::Mat::ones(2, 3, CV_32FC1)));
  EXPECT_THROWS(RunNbvDatasetExperiment(options_), ConfigError,
                "41: Front_Up has a depth of another size");
}

TEST_F(NbvDataset, NamesWhatIsMissing) {
  ExperimentOptions none = options_;
  none.classifier = "";
  EXPECT_THROWS(RunNbvDatasetExperiment(none), ConfigError, "needs --classifier FILE");
  none = options_;
  none.data = (folder_ / "nowhere").string();
  EXPECT_THROWS(RunNbvDatasetExperiment(none), ConfigError, "nowhere: no such folder");
  WriteSet(7, "Duck", {1, 2, 3});
  EXPECT_THROWS(RunNbvDatasetExperiment(options_), ConfigError,
                "'Duck' is no class of the classifier");
}

}  // namespace
}  // namespace secondlook::apps
