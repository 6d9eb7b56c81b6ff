#include "lib/perception/recognise.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/parallel.h"
#include "tests/perception/synthetic_view.h"
#include "tests/support/expect_throws.h"

namespace secondlook::perception {
namespace {

const Eigen::Vector3f kRed(0.8F, 0.15F, 0.1F);
const Eigen::Vector3f kBlue(0.1F, 0.2F, 0.8F);
const Eigen::Vector3f kGreen(0.1F, 0.6F, 0.2F);
const Eigen::Vector3f kWhite(0.9F, 0.9F, 0.9F);

/// An L, two boxes that differ in their label only, and a small cube; trained once.
class Recognising : public ::testing::Test {
 protected:
  static const std::vector<RecognitionModel>& Models() {
    static const std::vector<RecognitionModel> models = TrainModels(world::ObjectDatabase(
        {MakeEll("ell", kRed, kGreen), MakeBoxModel("tea_blue", {0.12, 0.08, 0.16}, kWhite, kBlue),
         MakeBoxModel("tea_red", {0.12, 0.08, 0.16}, kWhite, kRed),
         MakeBoxModel("cube", {0.05, 0.05, 0.05}, kGreen, kGreen)}));
    return models;
  }
  static const RecognitionModel& Model(const std::string& name) {
    for (const RecognitionModel& model : Models()) {
      if (model.name == name) return model;
    }
    throw std::runtime_error(name);
  }

  /// What is chosen for the first cluster of the view: a name, or why there is none.
  static std::string Chosen(const SyntheticView& scene, const std::vector<RecognitionModel>& models,
                            world::Hypothesis* chosen) {
    const auto detections = Recognise(scene.view, scene.clusters, models, config_);
    const auto choices = ChooseHypotheses(detections, models, config_);
    if (choices.at(0).hypothesis < 0) return choices[0].reason;
    *chosen = detections[0].hypotheses[static_cast<std::size_t>(choices[0].hypothesis)];
    return chosen->model;
  }

  static inline const RecogniseConfig config_;
};

TEST_F(Recognising, FindsAnObjectWithoutSymmetryWhereverItStands) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Rng rng(seed);
    const Pose X_WM = Upright(rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1), rng.Uniform(-3, 3));
    const SyntheticView scene = DrawView({{&Model("ell"), X_WM}}, rng.Uniform(0, 6), true, &rng);
    world::Hypothesis chosen;
    ASSERT_EQ(Chosen(scene, Models(), &chosen), "ell") << "seed " << seed;
    const Pose X_CM = scene.X_WC.inverse() * X_WM;
    EXPECT_LT((chosen.X_CM.translation() - X_CM.translation()).norm(), 0.0025) << "seed " << seed;
    EXPECT_LT(RotationDistance(chosen.X_CM.linear(), X_CM.linear()), 0.02) << "seed " << seed;
  }
}

TEST_F(Recognising, TellsBoxesApartByTheirPrintWhereItShows) {
  Rng rng(1);
  for (const char* name : {"tea_blue", "tea_red"}) {
    // The label is on the side -y; the camera stands there, a little to the side.
    const Pose X_WM = Upright(0.02, 0.0, 0.3);
    const SyntheticView scene = DrawView({{&Model(name), X_WM}}, -std::numbers::pi / 2, true, &rng);
    world::Hypothesis chosen;
    EXPECT_EQ(Chosen(scene, Models(), &chosen), name);
    const Pose X_CM = scene.X_WC.inverse() * X_WM;
    const PoseDistance d =
        DistanceUpToSymmetry(X_CM, chosen.X_CM, Model(name).symmetry, Model(name).center_M, true);
    EXPECT_LT(d.rotation, 0.05);
    EXPECT_LT(d.translation, 0.005);
  }
}

TEST_F(Recognising, IsNotDisturbedByAModelOfOneTriangle) {
  Rng rng(5);
  world::ObjectModel sheet = MakeEll("sheet", kRed, kRed);
  sheet.mesh.triangles.resize(1);
  sheet.mesh.triangle_material.resize(1);
  std::vector<RecognitionModel> models = Models();
  models.push_back(TrainModel(sheet));
  const SyntheticView scene = DrawView({{&Model("ell"), Upright(0.0, 0.0, 0.7)}}, 0.4, true, &rng);
  world::Hypothesis chosen;
  EXPECT_EQ(Chosen(scene, models, &chosen), "ell");
}

TEST_F(Recognising, IsUnsureOfBoxesWhosePrintIsTurnedAway) {
  Rng rng(2);
  const SyntheticView scene =
      DrawView({{&Model("tea_blue"), Upright(0.0, 0.0, 0.3)}}, std::numbers::pi / 2, true, &rng);
  world::Hypothesis chosen;
  EXPECT_THAT(Chosen(scene, Models(), &chosen), ::testing::HasSubstr("is not enough ahead of"));
}

TEST_F(Recognising, ReadsTheSideOnWhichANearlySquareBrickHasItsLabel) {
  const std::vector<RecognitionModel> brick{
      TrainModel(MakeBoxModel("brick", {0.06, 0.064, 0.16}, kWhite, kBlue))};
  Rng rng(10);
  for (const double yaw : {0.0, 0.5, -0.5}) {
    const Pose X_WM = Upright(0.0, 0.0, yaw);
    const SyntheticView scene = DrawView({{&brick[0], X_WM}}, -std::numbers::pi / 2, true, &rng);
    world::Hypothesis chosen;
    ASSERT_EQ(Chosen(scene, brick, &chosen), "brick") << "yaw " << yaw;
    const PoseDistance d = DistanceUpToSymmetry(scene.X_WC.inverse() * X_WM, chosen.X_CM,
                                                brick[0].symmetry, brick[0].center_M, true);
    EXPECT_LT(d.rotation, 0.1) << "yaw " << yaw;
  }
}

TEST_F(Recognising, IsUnsureOnWhichHiddenSideANearlySquareBrickHasItsLabel) {
  const std::vector<RecognitionModel> brick{
      TrainModel(MakeBoxModel("brick", {0.06, 0.064, 0.16}, kWhite, kBlue))};
  Rng rng(11);
  // Seen over an edge, two sides show and two are hidden; the label (-y) is turned away.
  const SyntheticView scene = DrawView({{&brick[0], Upright(0.0, 0.0, std::numbers::pi / 4)}},
                                       std::numbers::pi / 2, true, &rng);
  world::Hypothesis chosen;
  EXPECT_THAT(Chosen(scene, brick, &chosen), ::testing::HasSubstr("another pose of it"));
}

TEST_F(Recognising, FindsAnObjectHalfHiddenByAnother) {
  Rng rng(3);
  // Seen from azimuth 0, the box stands before one side of the L.
  const SyntheticView scene = DrawView(
      {{&Model("ell"), Upright(-0.05, 0.0, 1.2)}, {&Model("tea_red"), Upright(0.08, 0.09, 1.57)}},
      0.0, true, &rng);
  world::Hypothesis chosen;
  ASSERT_EQ(Chosen(scene, Models(), &chosen), "ell");
  EXPECT_LT(chosen.verification.visible_fraction, 0.95);
}

TEST_F(Recognising, DoesNotTakeAnUnknownThingForAKnownOne) {
  Rng rng(4);
  std::vector<RecognitionModel> others = Models();
  std::erase_if(others, [](const RecognitionModel& model) { return model.name == "ell"; });
  for (int i = 0; i < 4; ++i) {
    const SyntheticView scene =
        DrawView({{&Model("ell"), Upright(0.0, 0.0, 1.5 * i)}}, 0.4, true, &rng);
    const auto detections = Recognise(scene.view, scene.clusters, others, config_);
    EXPECT_EQ(ChooseHypotheses(detections, Models(), config_).at(0).hypothesis, -1);
    EXPECT_FALSE(detections.at(0).reason.empty());
  }
}

TEST_F(Recognising, GivesTheSameForAnyNumberOfThreads) {
  Rng rng(5);
  const SyntheticView scene = DrawView(
      {{&Model("ell"), Upright(-0.1, 0.1, 0.5)}, {&Model("tea_red"), Upright(0.1, -0.1, 2.0)}}, 0.8,
      true, &rng);
  std::vector<std::vector<world::Detection>> results;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    results.push_back(Recognise(scene.view, scene.clusters, Models(), config_));
  }
  ASSERT_EQ(results[0].size(), results[1].size());
  for (std::size_t c = 0; c < results[0].size(); ++c) {
    const auto& one = results[0][c].hypotheses;
    const auto& two = results[1][c].hypotheses;
    ASSERT_EQ(one.size(), two.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(one[i].model, two[i].model);
      EXPECT_EQ(one[i].score, two[i].score);
      EXPECT_EQ(one[i].X_CM.matrix(), two[i].X_CM.matrix());
    }
  }
}

TEST_F(Recognising, SaysThatNoModelIsLargeEnough) {
  Rng rng(6);
  const std::vector<RecognitionModel> cube{Model("cube")};
  const SyntheticView scene = DrawView({{&Model("ell"), Upright(0, 0, 0)}}, 0.5, true, &rng);
  const auto detections = Recognise(scene.view, scene.clusters, cube, config_);
  EXPECT_TRUE(detections.at(0).hypotheses.empty());
  EXPECT_THAT(detections[0].reason, ::testing::HasSubstr("none of 1 models fits"));
}

TEST_F(Recognising, WorksWithoutColour) {
  Rng rng(7);
  SyntheticView scene = DrawView({{&Model("ell"), Upright(0, 0, 0.7)}}, 0.5, true, &rng);
  scene.view.color = cv::Mat();
  world::Hypothesis chosen;
  EXPECT_EQ(Chosen(scene, Models(), &chosen), "ell");
  EXPECT_TRUE(std::isnan(chosen.verification.color_agreement));
}

TEST_F(Recognising, OfNothingMakesNothing) {
  Rng rng(8);
  const SyntheticView scene = DrawView({}, 0.5, false, &rng);
  EXPECT_TRUE(Recognise(scene.view, {}, Models(), config_).empty());
  const SyntheticView full = DrawView({{&Model("ell"), Upright(0, 0, 0)}}, 0.5, false, &rng);
  const auto detections = Recognise(full.view, full.clusters, {}, config_);
  ASSERT_EQ(detections.size(), 1U);
  EXPECT_THAT(detections[0].reason, ::testing::HasSubstr("none of 0 models"));
}

TEST_F(Recognising, RefusesImagesThatDoNotFitTheCamera) {
  Rng rng(9);
  const SyntheticView scene = DrawView({}, 0.5, false, &rng);
  geometry::CameraModel camera = scene.view.camera;
  camera.width = 320;
  EXPECT_THROWS(MakeView(scene.view.color, scene.view.depth, camera, scene.view.plane_C, {}),
                InvalidArgument, "the colour image is 640 x 480");
  world::Cluster outside;
  outside.pixels = {640 * 480};
  EXPECT_THROWS(MakeView({}, scene.view.depth, scene.view.camera, scene.view.plane_C, {outside}),
                InvalidArgument, "cluster 0 has pixel 307200");
}

TEST(RecogniseConfig, NamesTheValueThatIsOutOfRange) {
  RecogniseConfig config;
  EXPECT_NO_THROW(config.Validate());
  config.guesses_per_model = 0;
  EXPECT_THROWS(config.Validate(), ConfigError, "guesses_per_model = 0 must lie in 1..1000");
  config = {};
  config.min_score = std::nan("");
  EXPECT_THROWS(config.Validate(), ConfigError, "min_score = nan must lie in 0..1");
  config = {};
  config.tolerance_deg = 181;
  EXPECT_THROWS(config.Validate(), ConfigError, "tolerance_deg = 181 must lie in 0..180");
  config = {};
  config.verify.min_matching = 85;
  EXPECT_THROWS(config.Validate(), ConfigError, "min_matching = 85 must lie in 0..1");
}

TEST_F(Recognising, TakesPosesThatNothingTellsApartForOne) {
  const RecognitionModel& cube = Model("cube");
  world::Hypothesis one;
  one.model = "cube";
  one.score = 0.99;
  one.verification.accepted = true;
  world::Hypothesis turned = one;
  turned.X_CM =
      Pose(Eigen::Translation3d(cube.center_M) * Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitZ()) *
           Eigen::Translation3d(-cube.center_M));
  world::Detection detection;
  detection.hypotheses = {one, turned};
  // The corners of a cube of 5 cm move by 1 mm in 0.03 rad, and by 14 mm in 0.4 rad.
  RecogniseConfig config;
  config.tolerance_m = 0.0;
  EXPECT_EQ(ChooseHypotheses({detection}, Models(), config)[0].hypothesis, 0);
  detection.hypotheses[1].X_CM =
      Pose(Eigen::Translation3d(cube.center_M) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) *
           Eigen::Translation3d(-cube.center_M));
  EXPECT_THAT(ChooseHypotheses({detection}, Models(), config_)[0].reason,
              ::testing::HasSubstr("is not enough ahead of another pose of it"));
}

TEST_F(Recognising, TakesPosesWithinTheToleranceForOneAnswer) {
  const RecognitionModel& ell = Model("ell");
  world::Hypothesis one;
  one.model = "ell";
  one.score = 0.99;
  one.verification.accepted = true;
  world::Detection detection;
  detection.hypotheses = {one, one};
  const auto chosen_beside = [&](double degrees, double metres) {
    Pose& X_CM = detection.hypotheses[1].X_CM;
    X_CM = Pose(Eigen::Translation3d(0.0, metres, 0.0)) *
           TurnAbout({ell.center_M, Eigen::Vector3d::UnitZ()}, degrees * std::numbers::pi / 180.0);
    return ChooseHypotheses({detection}, Models(), config_)[0].hypothesis;
  };
  EXPECT_EQ(chosen_beside(14.0, 0.0), 0);
  EXPECT_EQ(chosen_beside(16.0, 0.0), -1);
  EXPECT_EQ(chosen_beside(0.0, 0.029), 0);
  EXPECT_EQ(chosen_beside(0.0, 0.031), -1);
}

TEST(ChooseHypotheses, TakesWhatIsAcceptedAndAheadOfEveryRival) {
  world::Detection detection;
  world::Hypothesis mug;
  mug.model = "mug";
  mug.score = 0.99;
  mug.verification.accepted = true;
  world::Hypothesis bowl;
  bowl.model = "bowl";
  bowl.score = 0.5;
  detection.hypotheses = {mug, bowl};
  const RecogniseConfig config;
  EXPECT_EQ(ChooseHypotheses({detection}, {}, config)[0].hypothesis, 0);

  detection.hypotheses[1].score = 0.985;
  const Choice close = ChooseHypotheses({detection}, {}, config)[0];
  EXPECT_EQ(close.hypothesis, -1);
  EXPECT_THAT(close.reason, ::testing::HasSubstr("mug (score 0.990) is not enough ahead of bowl"));

  detection.hypotheses = {mug};
  detection.hypotheses[0].verification.accepted = false;
  detection.reason = "nearest is mug: the camera sees through it";
  const Choice none = ChooseHypotheses({detection}, {}, config)[0];
  EXPECT_EQ(none.hypothesis, -1);
  EXPECT_EQ(none.reason, detection.reason);
}

}  // namespace
}  // namespace secondlook::perception
