#include "lib/perception/regroup.h"

#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/perception/explain.h"
#include "tests/perception/synthetic_view.h"

namespace secondlook::perception {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

const Eigen::Vector3f kRed(0.8F, 0.15F, 0.1F);
const Eigen::Vector3f kBlue(0.1F, 0.2F, 0.8F);
const Eigen::Vector3f kGreen(0.1F, 0.6F, 0.2F);
const Eigen::Vector3f kYellow(0.8F, 0.7F, 0.1F);

/// Known: an L, a blue box and a box as high and as deep as that with a red front on green.
class RecognisingRegrouped : public ::testing::Test {
 protected:
  static const std::vector<RecognitionModel>& Models() {
    static const std::vector<RecognitionModel> models = TrainModels(world::ObjectDatabase(
        {MakeEll("ell", kRed, kGreen), MakeBoxModel("blue", {0.09, 0.07, 0.11}, kBlue, kYellow),
         MakeBoxModel("green", {0.12, 0.07, 0.11}, kGreen, kRed)}));
    return models;
  }
  static const RecognitionModel& Model(const std::string& name) {
    return *FindModel(Models(), name);
  }

  /// Recognises `things`, of which segmentation joined all (`joined`) or told all apart.
  static Regrouped Recognised(const std::vector<Placed>& things, bool joined) {
    Rng rng(1);
    SyntheticView scene = DrawView(things, -1.2, true, &rng);
    std::vector<world::Cluster> clusters = std::move(scene.clusters);
    if (joined) {
      std::vector<int> pixels;
      for (const world::Cluster& cluster : clusters) {
        pixels.insert(pixels.end(), cluster.pixels.begin(), cluster.pixels.end());
      }
      clusters = {MakeCluster(pixels, scene.view.depth, scene.view.camera)};
    }
    const View view = MakeView(scene.view.color, scene.view.depth, scene.view.camera,
                               scene.view.plane_C, clusters);
    return RecogniseRegrouping(view, clusters, Models(), {});
  }

  static std::vector<std::string> Names(const Regrouped& found) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < found.detections.size(); ++i) {
      const int chosen = found.choices[i].hypothesis;
      names.push_back(chosen < 0
                          ? "open"
                          : found.detections[i].hypotheses[static_cast<std::size_t>(chosen)].model);
    }
    return names;
  }
};

TEST_F(RecognisingRegrouped, TellsTwoEqualBoxesThatTouchApart) {
  const Regrouped found = Recognised(
      {{&Model("blue"), Upright(-0.045, 0.0, 0.0)}, {&Model("blue"), Upright(0.045, 0.0, 0.0)}},
      true);
  EXPECT_THAT(Names(found), ElementsAre("blue", "blue"));
  EXPECT_THAT(found.sources, ElementsAre(ElementsAre(0), ElementsAre(0)));
}

TEST_F(RecognisingRegrouped, TellsTwoDifferentBoxesInOneClusterApart) {
  const Regrouped found = Recognised(
      {{&Model("blue"), Upright(-0.045, 0.0, 0.0)}, {&Model("green"), Upright(0.06, 0.0, 0.0)}},
      true);
  EXPECT_THAT(Names(found), UnorderedElementsAre("blue", "green"));
}

TEST_F(RecognisingRegrouped, TellsThreeInARowApart) {
  const Regrouped found = Recognised({{&Model("blue"), Upright(-0.09, 0.0, 0.0)},
                                      {&Model("blue"), Upright(0.0, 0.0, 0.0)},
                                      {&Model("blue"), Upright(0.09, 0.0, 0.0)}},
                                     true);
  EXPECT_THAT(Names(found), ElementsAre("blue", "blue", "blue"));
}

TEST_F(RecognisingRegrouped, DoesNotCutABoxWhoseColoursMeetInAStraightEdge) {
  const Regrouped found = Recognised({{&Model("ell"), Upright(0.0, 0.0, 0.3)}}, true);
  EXPECT_THAT(Names(found), ElementsAre("ell"));
}

TEST_F(RecognisingRegrouped, LeavesWhatNoModelExplainsInOnePiece) {
  const std::vector<RecognitionModel> unknown =
      TrainModels(world::ObjectDatabase({MakeBoxModel("new", {0.2, 0.1, 0.08}, kBlue, kBlue)}));
  const Regrouped found = Recognised({{&unknown[0], Upright(0.0, 0.0, 0.4)}}, true);
  EXPECT_THAT(Names(found), ElementsAre("open"));
}

TEST_F(RecognisingRegrouped, JoinsThePiecesOfOneThing) {
  Rng rng(1);
  SyntheticView scene = DrawView({{&Model("green"), Upright(0.0, 0.0, 0.4)}}, -1.2, true, &rng);
  // Cut where its picture is halved: neither half shows how wide it is.
  std::array<std::vector<int>, 2> halves;
  const int middle =
      static_cast<int>(std::lround(scene.view.camera.Project(scene.clusters[0].center_C)->x()));
  for (const int pixel : scene.clusters[0].pixels) halves[pixel % 640 < middle].push_back(pixel);
  const std::vector<world::Cluster> clusters{
      MakeCluster(halves[0], scene.view.depth, scene.view.camera),
      MakeCluster(halves[1], scene.view.depth, scene.view.camera)};
  const View view =
      MakeView(scene.view.color, scene.view.depth, scene.view.camera, scene.view.plane_C, clusters);
  const Regrouped found = RecogniseRegrouping(view, clusters, Models(), {});
  EXPECT_THAT(Names(found), ElementsAre("green"));
  EXPECT_THAT(found.sources, ElementsAre(ElementsAre(0, 1)));
  EXPECT_EQ(found.detections[0].cluster.pixels, scene.clusters[0].pixels);
}

TEST_F(RecognisingRegrouped, OfNothingMakesNothing) {
  EXPECT_THAT(Recognised({}, false).detections, IsEmpty());
}

}  // namespace
}  // namespace secondlook::perception
