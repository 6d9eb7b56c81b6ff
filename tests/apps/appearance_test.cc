#include "apps/appearance.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "apps/experiments/free_camera.h"
#include "apps/experiments/single_view.h"
#include "apps/run_config.h"
#include "apps/scene_understanding.h"
#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/perception/appearance/feature_classifier.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using world::ObjectState;

/// Says the same of every picture.
class Stubborn : public perception::Classifier {
 public:
  Stubborn(std::vector<std::string> classes, std::vector<double> says, double accuracy)
      : classes_(std::move(classes)), says_(std::move(says)), accuracy_(accuracy) {}

  const std::vector<std::string>& classes() const override { return classes_; }
  std::vector<double> Classify(const cv::Mat& image) const override {
    shown = image.size();
    return says_;
  }
  double held_out_accuracy() const override { return accuracy_; }

  mutable cv::Size shown;

 private:
  std::vector<std::string> classes_;
  std::vector<double> says_;
  double accuracy_;
};

/// A filled rectangle in an image of 100 pixels in width.
world::Cluster Filled(const cv::Rect& rect) {
  world::Cluster cluster;
  for (int v = rect.y; v < rect.br().y; ++v) {
    for (int u = rect.x; u < rect.br().x; ++u) cluster.pixels.push_back(v * 100 + u);
  }
  return cluster;
}

const cv::Mat kGrey(80, 100, CV_8UC3, cv::Scalar::all(128));

TEST(LooksOf, ShowsTheClassifierTheBoxAndTakesTheUnknownForIgnorance) {
  const Stubborn classifier({"mug", "oat", "Background", "unknown"}, {0.6, 0.2, 0.05, 0.15}, 0.9);
  const world::MassFunction masses = LooksOf(Filled({10, 20, 30, 15}), kGrey, classifier);
  EXPECT_EQ(classifier.shown, cv::Size(30, 15));
  EXPECT_NEAR(masses.Of("mug"), 0.54, 1e-12);
  EXPECT_NEAR(masses.Of("oat"), 0.18, 1e-12);
  EXPECT_NEAR(masses.omega, 0.1 + 0.9 * 0.2, 1e-12);
  EXPECT_EQ(masses.singletons.size(), 2U);
}

TEST(LooksOf, SaysNothingOfWhatIsTooSmallOrHasNoColour) {
  const Stubborn classifier({"mug", "oat"}, {1.0, 0.0}, 1.0);
  EXPECT_EQ(LooksOf(Filled({10, 20, 30, 11}), kGrey, classifier).omega, 1.0);
  EXPECT_EQ(LooksOf(Filled({10, 20, 30, 30}), cv::Mat(), classifier).omega, 1.0);
}

/// Crops of `name` alone on a table, as segmentation cuts them out, from `views` sides.
std::vector<cv::Mat> Crops(const std::string& name, int views) {
  sim::Scene scene;
  scene.table.size = {0.8, 0.6};
  scene.table.color = {0.4, 0.45, 0.5};
  sim::SceneObject object;
  object.mesh = "sim/models/" + name + "/mesh.obj";
  object.name = name;
  object.position = {0.0, 0.0};
  scene.objects.push_back(object);
  FreeCamera camera(scene, 1);
  std::vector<cv::Mat> crops;
  for (int i = 0; i < views; ++i) {
    const double azimuth = 6.2831853 * i / views;
    const Vector3d eye(0.8 * std::cos(azimuth), 0.8 * std::sin(azimuth), 1.25);
    const Photo photo = camera.Take(LookAt(eye, {0.0, 0.0, 0.8}));
    const std::optional<CutPhoto> cut = Cut(photo, camera.info().model);
    if (!cut || cut->clusters.empty()) continue;
    const cv::Rect box = BoundingBox(cut->clusters.front(), photo.frame.color.cols);
    crops.push_back(photo.frame.color(box).clone());
  }
  return crops;
}

/// A machine that has learnt a book and a canister from pictures.
std::unique_ptr<perception::Classifier> BookOrCanister() {
  perception::TrainingSet set{{"book", "canister_blue"}, {}, {}, "fnv1a 1"};
  for (int label = 0; label < 2; ++label) {
    for (const cv::Mat& crop : Crops(set.classes[label], 6)) {
      set.images.push_back({set.classes[label], label, crop});
    }
  }
  return perception::FeatureClassifier::Train(perception::FeatureClassifierKind::kSvm, set,
                                              {2, 1, 1}, [](const std::string&) {});
}

TEST(SceneUnderstanding, JoinsWhatAThingLooksLikeWithItsShape) {
  const auto classifier = BookOrCanister();
  sim::Scene scene;
  scene.table.size = {0.8, 0.6};
  for (const auto& [name, y] : {std::pair{"canister_blue", -0.15}, {"book", 0.15}}) {
    sim::SceneObject object;
    object.mesh = fmt::format("sim/models/{}/mesh.obj", name);
    object.name = name;
    object.position = {0.0, y};
    scene.objects.push_back(object);
  }
  FreeCamera camera(scene, 2);
  // There is no model of the book, so that it is known by its looks or not at all.
  const world::ObjectDatabase database({world::ReadModel("sim/models/canister_blue")});
  SceneUnderstanding understanding({}, {}, database);
  understanding.KnowClassifier(*classifier);
  for (const double azimuth : {0.3, 1.6, 3.0}) {
    const Vector3d eye(0.85 * std::cos(azimuth), 0.85 * std::sin(azimuth), 1.3);
    const Photo photo = camera.Take(LookAt(eye, {0.0, 0.0, 0.8}));
    ASSERT_EQ(understanding.Add({"head", photo.frame, camera.info().model, photo.X_WC,
                                 Vector3d(0.0, 0.0, -eye.z())}),
              "");
  }
  ASSERT_EQ(understanding.belief().objects.size(), 2U);
  for (const world::ObjectBelief& object : understanding.belief().objects) {
    const bool canister = object.extent_W.center().y() < 0.0;
    EXPECT_EQ(object.LeadingClass(), canister ? "canister_blue" : "book") << object.reason;
    EXPECT_EQ(object.state, canister ? ObjectState::kVerified : ObjectState::kClassified)
        << object.reason;
  }
}

TEST(LoadMissionClassifier, NamesBothListsWhenTheyHaveNothingInCommon) {
  const TemporaryFolder folder;
  perception::TrainingSet set{{"cat", "dog"}, {}, {}, "fnv1a 1"};
  for (int i = 0; i < 8; ++i) {
    set.images.push_back(
        {"", i % 2, cv::Mat(24, 24, CV_8UC3, cv::Scalar(20 * i, 200 - 20 * i, 30 * (i % 2)))});
  }
  perception::FeatureClassifier::Train(perception::FeatureClassifierKind::kSvm, set, {2, 1, 1},
                                       [](const std::string&) {})
      ->Save(folder / "pets.yml");
  const world::ObjectDatabase database({world::ReadModel("sim/models/mug")});
  EXPECT_THROWS(LoadMissionClassifier(folder / "pets.yml", database), ConfigError,
                "pets.yml: tells of cat, dog, unknown, which are none of the models mug");
  EXPECT_EQ(LoadMissionClassifier("", database), nullptr);
  EXPECT_THROWS(LoadMissionClassifier(folder / "none.yml", database), ConfigError, "none.yml");
}

TEST(RunConfig, TakesTheClassifierRelativeToTheFile) {
  const TemporaryFolder folder;
  WriteFile(folder / "c.yaml",
            "robot: !Sim {scene: s.yaml}\nmodels: m\nclassifier: looks/objects.yml\n");
  const RunConfig config = LoadRunConfig(folder / "c.yaml", {});
  EXPECT_EQ(config.classifier, (folder / "looks/objects.yml").string());
}

}  // namespace
}  // namespace secondlook::apps
