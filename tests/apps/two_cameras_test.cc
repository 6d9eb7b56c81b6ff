#include "apps/experiments/two_cameras.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/free_camera.h"
#include "apps/experiments/random_scene.h"
#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::apps {
namespace {

/// Three things of sim/models.
std::vector<sim::SceneObject> Things() {
  std::vector<sim::SceneObject> things = LoadRepertoire("sim/models", "").known;
  std::erase_if(things, [](const sim::SceneObject& thing) {
    return !std::set<std::string>{"bowl", "oat_box", "mug"}.contains(thing.name);
  });
  return things;
}

/// Knows nothing of anything.
class Ignorant : public perception::Classifier {
 public:
  const std::vector<std::string>& classes() const override { return classes_; }
  std::vector<double> Classify(const cv::Mat&) const override { return {0.5, 0.5}; }
  double held_out_accuracy() const override { return 0.5; }

 private:
  std::vector<std::string> classes_{"bowl", "mug"};
};

TEST(WithOccluders, HidesPartsOfThingsFromTheEyeItIsGiven) {
  const sim::Scene scene = DrawTestTable(Things(), 1);
  ASSERT_EQ(scene.objects.size(), 3U);
  const Eigen::Vector3d p_WEye(1.2, 0.3, 1.2);
  const sim::Scene hidden = WithOccluders(scene, p_WEye, 2, 1);
  ASSERT_FALSE(hidden.boxes.empty());
  EXPECT_LE(hidden.boxes.size(), 2U);
  const auto shares = [&](const sim::Scene& of) {
    FreeCamera camera(of, 1);
    return camera.VisibleShares(camera.Take(LookAt(p_WEye, {0.0, 0.0, scene.table.height})));
  };
  const std::vector<double> before = shares(scene);
  const std::vector<double> after = shares(hidden);
  int partly = 0;
  for (std::size_t i = 0; i < before.size(); ++i) partly += after[i] < before[i] - 0.1 ? 1 : 0;
  EXPECT_GE(partly, 1);
}

TEST(LookTwice, MatchesWhatBothCamerasSee) {
  const TwoViews views = LookTwice(DrawTestTable(Things(), 1), Ignorant(), 1);
  std::set<int> seen;
  for (const Sighted& sighted : views.head) seen.insert(sighted.thing);
  EXPECT_EQ(seen, (std::set<int>{0, 1, 2}));
  ASSERT_FALSE(views.matches.empty());
  for (const fusion::CrossMatch& match : views.matches) {
    EXPECT_EQ(views.head[static_cast<std::size_t>(match.object)].thing,
              views.hand[static_cast<std::size_t>(match.box)].thing);
  }
}

TEST(OneBudgetExperiment, NamesTheTwinThatIsMissing) {
  ExperimentOptions options;
  options.models = "sim/unfamiliar";
  EXPECT_THROWS(RunOneBudgetExperiment(options), ConfigError,
                "sim/unfamiliar: has no 'block_plain'; one-budget needs the twins of sim/models");
}

}  // namespace
}  // namespace secondlook::apps
