#include "apps/experiments/experiment.h"

#include <algorithm>
#include <atomic>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

/// A trial whose result is the square of its number.
Json Square(int t) { return {{"square", t * t}}; }

std::vector<Row> Summary(const std::vector<Json>& trials) {
  std::vector<double> squares;
  for (const Json& trial : trials) squares.push_back(trial["square"]);
  return {{"square", Mean(squares)}};
}

std::vector<int> Numbers(const std::vector<Json>& trials) {
  std::vector<int> numbers;
  for (const Json& trial : trials) numbers.push_back(trial["trial"]);
  return numbers;
}

class Trials : public ::testing::Test {
 protected:
  Trials() {
    options_.trials = 7;
    options_.json = (folder_ / "result.json").string();
  }
  Json Written() const { return Json::parse(ReadFile(options_.json)); }

  TemporaryFolder folder_;
  ExperimentOptions options_;
};

TEST_F(Trials, ComeInTheirOrderWithTheirSummary) {
  const auto trials = RunTrials("squares", options_, Square, Summary);
  EXPECT_EQ(Numbers(trials), (std::vector<int>{0, 1, 2, 3, 4, 5, 6}));
  const Json result = Written();
  EXPECT_EQ(result["name"], "squares");
  EXPECT_EQ(result["trials"], 7);
  EXPECT_EQ(result["seed"], 1);
  EXPECT_EQ(result["rows"][0]["metric"], "square");
  EXPECT_DOUBLE_EQ(result["rows"][0]["value"], 13.0);  // (0 + 1 + 4 + 9 + 16 + 25 + 36) / 7
  EXPECT_EQ(result["rows"][0]["ci95"].size(), 2U);
  EXPECT_TRUE(result["rows"][0]["paper"].is_null());
  EXPECT_TRUE(result["seconds"].is_number());
  EXPECT_EQ(result["details"].size(), 7U);
}

TEST_F(Trials, ComeWithThePublishedFigureAndTheBaselineWhereThereIsOne) {
  RunTrials("squares", options_, Square, [](const std::vector<Json>&) {
    return std::vector<Row>{{"published", {1.0, 0.5, 1.5}, 0.75, 0.25}};
  });
  const Json row = Written()["rows"][0];
  EXPECT_DOUBLE_EQ(row["paper"], 0.75);
  EXPECT_DOUBLE_EQ(row["baseline"], 0.25);
}

TEST_F(Trials, AreTheSameForAnyNumberOfThreads) {
  options_.threads = 1;
  RunTrials("squares", options_, Square, Summary);
  Json one = Written();
  options_.threads = 4;
  RunTrials("squares", options_, Square, Summary);
  Json four = Written();
  one.erase("seconds");
  four.erase("seconds");
  EXPECT_EQ(one, four);
}

TEST_F(Trials, AreSharedOutAmongTheShards) {
  std::vector<int> all;
  options_.shards = 3;
  for (options_.shard = 1; options_.shard <= 3; ++options_.shard) {
    for (const int t : Numbers(RunTrials("squares", options_, Square, Summary))) all.push_back(t);
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, (std::vector<int>{0, 1, 2, 3, 4, 5, 6}));
}

TEST_F(Trials, ThatStandInTheFileAreNotRunAgain) {
  options_.trials = 3;
  RunTrials("squares", options_, Square, Summary);
  options_.trials = 5;
  options_.resume = true;
  std::atomic<int> run{0};
  const auto trials = RunTrials(
      "squares", options_,
      [&](int t) {
        ++run;
        return Square(t);
      },
      Summary);
  EXPECT_EQ(run, 2);
  EXPECT_EQ(Numbers(trials), (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST_F(Trials, DoNotResumeWhatIsAnotherExperiment) {
  RunTrials("squares", options_, Square, Summary);
  options_.resume = true;
  EXPECT_THROWS(RunTrials("cubes", options_, Square, Summary), ConfigError,
                "is not the result of 'experiment cubes' with seed 1, models");
  options_.seed = 2;
  EXPECT_THROWS(RunTrials("squares", options_, Square, Summary), ConfigError, "with seed 2");
  options_.seed = 1;
  options_.views = 9;
  EXPECT_THROWS(RunTrials("squares", options_, Square, Summary), ConfigError, "and 9 views");
  options_.views = 0;
  options_.scene = "another.yaml";
  EXPECT_THROWS(RunTrials("squares", options_, Square, Summary), ConfigError, "'another.yaml'");
  WriteFile(options_.json, "{");
  EXPECT_THROWS(RunTrials("squares", options_, Square, Summary), ConfigError, "nothing to resume");
}

TEST_F(Trials, OfRecognitionJudgeEveryObjectOfEveryView) {
  options_.trials = 1;
  options_.views = 2;
  options_.models = "sim/models";
  RunRecognitionExperiment(options_);
  const Json result = Written();
  const Json& views = result["details"][0]["views"];
  ASSERT_EQ(views.size(), 2U);
  int found = 0;
  int right = 0;
  for (const Json& view : views) {
    EXPECT_EQ(view["objects"].size(), 7U);
    for (const Json& object : view["objects"]) {
      const double visible = object["visible"];
      EXPECT_GE(visible, 0.0);
      EXPECT_LE(visible, 1.0);
      if (!object["found"]) continue;
      ++found;
      EXPECT_GT(visible, 0.0) << object["name"];
    }
    for (const Json& detection : view["detections"]) {
      if (!detection["right"]) continue;
      ++right;
      EXPECT_LE(detection["error_mm"], 30.0);
      EXPECT_LE(detection["error_deg"], 15.0);
    }
  }
  EXPECT_EQ(found, right) << "each thing is detected once";
  EXPECT_GT(found, 4) << "of 14, most of them in full view";
  EXPECT_EQ(result["rows"][2]["metric"], "recall, all not completely hidden");
  EXPECT_NEAR(result["rows"][2]["paper"], 0.752, 5e-4);
}

TEST_F(Trials, OfPoseAveragingGetNearerWithMoreViews) {
  options_.trials = 1;
  options_.views = 5;
  options_.models = "sim/models";
  RunPoseAveragingExperiment(options_);
  const Json result = Written();
  const Json& fused = result["details"][0]["fused"];
  ASSERT_EQ(fused.size(), 3U) << "after 1, 2 and 5 views";
  EXPECT_EQ(fused[2]["views"], 5);
  EXPECT_EQ(fused[0]["mean"], fused[0]["weighted"]) << "of one view";
  for (const char* method : {"mean", "weighted", "joint"}) {
    ASSERT_FALSE(fused[2][method].is_null()) << method;
    EXPECT_LT(fused[2][method]["error_mm"], 4.0) << method;
  }
}

TEST_F(Trials, OfSegmentationNeedNoData) {
  options_.trials = 2;
  options_.models = "sim/models";
  RunSegmentationExperiment(options_);
  const Json result = Written();
  for (const Json& trial : result["details"]) {
    const auto objects = trial["objects"].get<std::size_t>();
    EXPECT_GE(objects, 3U) << "of the seven on the table";
    EXPECT_LE(objects, 7U);
    EXPECT_EQ(trial["result"]["iou"].size(), objects);
  }
  EXPECT_NE(result["details"][0]["result"]["iou"], result["details"][1]["result"]["iou"]);
  EXPECT_GT(result["rows"][1]["value"], 0.7);
}

}  // namespace
}  // namespace secondlook::apps
