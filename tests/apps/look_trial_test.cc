#include "apps/experiments/look_trial.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/experiments/look_courses.h"
#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

SceneUnderstanding Knowing(const std::vector<std::string>& names) {
  std::vector<world::ObjectModel> models;
  for (const std::string& name : names) models.push_back(world::ReadModel("sim/models/" + name));
  return {{}, {}, world::ObjectDatabase(std::move(models))};
}

/// The tea box on a plinth.
sim::Scene TeaBox() {
  sim::Scene scene;
  scene.table.size = {0.5, 0.5};
  scene.table.height = 0.95;
  scene.table.solid = true;
  sim::SceneObject object;
  object.mesh = "sim/models/tea_box/mesh.obj";
  object.name = "tea_box";
  object.position = {0.0, 0.0};
  scene.objects = {object};
  return scene;
}

TEST(LookTrial, FindsTheSameFromTheSamePlaceWhoeverAsks) {
  const SceneUnderstanding blank = Knowing({"tea_box"});
  LookTrial trial(TeaBox(), 0, blank, {}, 1);
  LookTrial again(TeaBox(), 0, blank, {}, 1);
  const Stance start = trial.Facing(-1.2, 1.5);
  const Stance next = trial.Facing(-0.8, 1.2);
  trial.Begin(start);
  again.Begin(start);
  EXPECT_EQ(trial.FindingAfter(next).beliefs, trial.Judge(trial.After({next})).beliefs);
  again.VisibleShare(next);  // another view in between changes nothing
  EXPECT_EQ(again.FindingAfter(next).beliefs, trial.FindingAfter(next).beliefs);
  EXPECT_EQ(trial.After({next}).scene.belief().views.size(), 2U);
}

TEST(LookTrial, JudgesByTheTruth) {
  const SceneUnderstanding blank = Knowing({"tea_box"});
  LookTrial trial(TeaBox(), 0, blank, {}, 1);
  const Stance start = trial.Facing(-1.2, 1.2);
  const Finding alone = trial.FindingIn(start);
  EXPECT_TRUE(alone.right) << alone.reason;
  EXPECT_GT(alone.BeliefIn("tea_box"), 0.9);
  EXPECT_EQ(alone.BeliefIn("mug"), 0.0);
  EXPECT_GT(trial.VisibleShare(start), 0.98) << "nothing is in the way";
}

TEST(LookTrial, ChoosesOneOfTheCandidatesInEachWay) {
  const SceneUnderstanding blank = Knowing({"tea_box"});
  world::Task task;
  task.confidence = 0.999;
  LookTrial trial(TeaBox(), 0, blank, task, 1);
  trial.Begin(trial.Facing(-1.2, 1.5));
  for (const char* chooser : kChoosers) {
    const std::vector<world::Look> looks = trial.Candidates(trial.start(), chooser);
    ASSERT_NE(ChosenOf(looks), nullptr) << chooser;
    EXPECT_TRUE(ChosenOf(looks)->feasible) << chooser;
    if (chooser == std::string(kPaper)) {
      EXPECT_EQ(looks.size(), 38U);
    }
  }
}

TEST(LookTrial, LooksFromElsewhereOnceSomethingStandsInTheWay) {
  const SceneUnderstanding blank = Knowing({"tea_box", "canister_blue"});
  world::Task task;
  task.confidence = 0.999;  // more than a view tells
  sim::Scene cluttered = TeaBox();
  sim::SceneObject occluder;
  occluder.mesh = "sim/models/canister_blue/mesh.obj";
  occluder.name = "canister_blue";
  LookTrial clear(TeaBox(), 0, blank, task, 1);
  const Stance start = clear.Facing(-1.2, 1.5);
  clear.Begin(start);
  const std::vector<world::Look> without = clear.Candidates(clear.start(), kOurs);
  ASSERT_NE(ChosenOf(without), nullptr);
  const Stance chosen = StanceOf(*ChosenOf(without));
  // Where the robot would look from, something stands now.
  const Eigen::Vector2d way = Eigen::Vector2d(chosen.X_WB.x, chosen.X_WB.y).normalized();
  occluder.position = {0.16 * way.x(), 0.16 * way.y()};
  cluttered.objects.push_back(occluder);
  LookTrial hidden(cluttered, 0, blank, task, 1);
  ASSERT_LT(hidden.VisibleShare(chosen), 0.95);
  hidden.Begin(start);
  const std::vector<world::Look> with = hidden.Candidates(hidden.start(), kOurs);
  ASSERT_NE(ChosenOf(with), nullptr);
  EXPECT_GT(hidden.VisibleShare(StanceOf(*ChosenOf(with))), 0.95);
}

TEST(LookTrial, TheMapOfTheLastViewHasForgottenWhatOnlyTheFirstSaw) {
  const SceneUnderstanding blank = Knowing({"tea_box"});
  LookTrial trial(TeaBox(), 0, blank, {}, 1);
  trial.Begin(trial.Facing(-1.2, 1.2));
  const Knowledge& known = trial.After({trial.Facing(0.4, 1.2)});
  ASSERT_EQ(known.vain, "");
  const world::VoxelSpace last = LookTrial::MapOfLastView(known);
  // Halfway from the first camera to the box.
  const Eigen::Vector3d p_W(0.5 * 0.9 * std::cos(-1.2), 0.5 * 0.9 * std::sin(-1.2), 1.05);
  EXPECT_EQ(known.scene.space().At(p_W), world::Occupancy::kFree);
  EXPECT_EQ(last.At(p_W), world::Occupancy::kUnknown);
}

/// A trial whose course by each chooser took so many seconds, and whether it was good.
Json TrialWith(double paper_seconds, double our_seconds, bool good) {
  Json trial;
  for (const char* chooser : kChoosers) {
    trial["courses"][chooser] = {{"seconds", paper_seconds}, {"good", false}};
  }
  trial["courses"][kOurs] = {{"seconds", our_seconds}, {"good", good}};
  return trial;
}

const Row& RowOf(const std::vector<Row>& rows, const std::string& metric) {
  for (const Row& row : rows) {
    if (row.metric == metric) return row;
  }
  throw std::out_of_range(metric);
}

TEST(LookCourses, CountOnlyTrialsThatFoundAStart) {
  const std::vector<Json> trials{TrialWith(20.0, 8.0, true), Json::object(),
                                 TrialWith(30.0, 10.0, false), TrialWith(40.0, 12.0, true)};
  EXPECT_DOUBLE_EQ(StartRow(trials).estimate.value, 0.75);
  std::vector<Row> rows;
  AddShares(
      "good", trials, 0.5, [](const Json& c) { return c.at("good").get<bool>(); }, &rows);
  EXPECT_DOUBLE_EQ(RowOf(rows, "good, expected loss").estimate.value, 2.0 / 3.0);
  EXPECT_EQ(RowOf(rows, "good, expected loss").paper, 0.5);
  EXPECT_EQ(RowOf(rows, "good, expected loss").baseline, 0.0);
  EXPECT_EQ(RowOf(rows, "good, nearest").paper, std::nullopt);
  AddSeconds(trials, &rows);
  EXPECT_DOUBLE_EQ(RowOf(rows, "robot time [s], McGreavy").estimate.value, 30.0);
  const Estimate saved = RowOf(rows, "robot time saved against McGreavy [s]").estimate;
  EXPECT_DOUBLE_EQ(saved.value, 20.0);  // 12, 20 and 28
  EXPECT_GE(saved.low, 12.0);
  EXPECT_LE(saved.high, 28.0);
}

TEST(AmbiguityExperiment, NeedsTheTwins) {
  ExperimentOptions options;
  options.trials = 1;
  options.models = "sim/unfamiliar";
  EXPECT_THROWS(RunAmbiguityExperiment(options), ConfigError,
                "experiment ambiguity: there is no 'block_plain' among the models");
}

}  // namespace
}  // namespace secondlook::apps
