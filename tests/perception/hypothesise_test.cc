#include "lib/perception/hypothesise.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/perception/synthetic_view.h"

namespace secondlook::perception {
namespace {

const Eigen::Vector3f kRed(0.8F, 0.15F, 0.1F);
constexpr int kGuesses = 4;

/// The guess of `model` for the cluster `label` that is nearest to X_CM.
PoseDistance NearestGuess(const SyntheticView& scene, const RecognitionModel& model, int label,
                          const Pose& X_CM) {
  const world::Cluster& cluster = scene.clusters[static_cast<std::size_t>(label)];
  PoseDistance nearest{1e9, 1e9};
  for (const PoseGuess& guess :
       HypothesisePoses(model, scene.view, label, cluster,
                        OrientCluster(scene.view, label, cluster), kGuesses)) {
    const PoseDistance d =
        DistanceUpToSymmetry(X_CM, guess.X_CM, model.symmetry, model.center_M, false);
    if (d.translation < nearest.translation) nearest = d;
  }
  return nearest;
}

TEST(HypothesisePoses, AreNearTheTruthForABoxThatIsMostlyHidden) {
  // From -y, a screen stands before more than half of the box, and nothing on its plain front and
  // top says where along x it is, but that it ends on one side.
  const RecognitionModel box = TrainModel(MakeBoxModel("box", {0.24, 0.05, 0.10}, kRed, kRed));
  const RecognitionModel screen =
      TrainModel(MakeBoxModel("screen", {0.24, 0.02, 0.22}, kRed, kRed));
  for (const double x : {0.10, 0.12}) {
    Rng rng(1);
    const Pose X_WM = Upright(0.0, 0.0, 0.1);
    const SyntheticView scene =
        DrawView({{&box, X_WM}, {&screen, Upright(x, -0.16, 0.0)}}, -1.5708, true, &rng);
    const PoseDistance d = NearestGuess(scene, box, 0, scene.X_WC.inverse() * X_WM);
    EXPECT_LT(d.translation, 0.02) << x;
    EXPECT_LT(d.rotation, 0.05) << x;
  }
}

TEST(HypothesisePoses, AreNoneForAModelThatIsTooSmall) {
  const RecognitionModel box = TrainModel(MakeBoxModel("box", {0.24, 0.05, 0.10}, kRed, kRed));
  const RecognitionModel cube = TrainModel(MakeBoxModel("cube", {0.04, 0.04, 0.04}, kRed, kRed));
  Rng rng(1);
  const SyntheticView scene = DrawView({{&box, Upright(0.0, 0.0, 0.1)}}, -1.5708, true, &rng);
  const world::Cluster& cluster = scene.clusters[0];
  EXPECT_TRUE(HypothesisePoses(cube, scene.view, 0, cluster, OrientCluster(scene.view, 0, cluster),
                               kGuesses)
                  .empty());
}

}  // namespace
}  // namespace secondlook::perception
