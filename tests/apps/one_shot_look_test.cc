#include "apps/one_shot_look.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "lib/common/rng.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

const std::vector<std::string> kClasses{"mug", "oat", "rice"};

/// Has learnt kClasses and is right nine times of ten.
class NineOfTen : public perception::Classifier {
 public:
  const std::vector<std::string>& classes() const override { return kClasses; }
  std::vector<double> Classify(const cv::Mat&) const override { return {0.1, 0.45, 0.45}; }
  double held_out_accuracy() const override { return 0.9; }
};

world::ObjectBelief Between(double oat, double rice) {
  world::ObjectBelief object;
  object.masses.singletons = {{"oat", oat}, {"rice", rice}};
  object.masses.omega = 1.0 - oat - rice;
  return object;
}

double Gain(const world::ObjectBelief& object, double accuracy) {
  return ClassificationGain(object, {}, kClasses, accuracy, {});
}

TEST(ClassificationGain, IsWhatAPictureIsWorthToTheTask) {
  EXPECT_GT(Gain(Between(0.48, 0.48), 0.9), 0.01);
  EXPECT_GT(Gain(Between(0.48, 0.48), 0.9), Gain(Between(0.48, 0.48), 0.7));
  // One that guesses tells nothing, nor does any of what it has not learnt.
  EXPECT_NEAR(Gain(Between(0.48, 0.48), 1.0 / 3.0), 0.0, 1e-9);
  EXPECT_NEAR(Gain(Between(0.0, 0.0), 0.9), 0.0, 1e-9);
}

TEST(ClassBelief, SumsToOneAndDecidesForNoneOfThemNever) {
  const planning::Belief belief = ClassBelief(Between(0.6, 0.3), {});
  ASSERT_EQ(belief.alternatives.size(), 3U);
  EXPECT_NEAR(belief.alternatives[0].probability, 0.6, 1e-12);
  EXPECT_NEAR(belief.alternatives[2].probability, 0.1, 1e-12);
  EXPECT_GT(belief.alternatives[2].needed, 0.999999);
}

/// An object at the origin, seen from -x by a level camera whose image is flat grey but for a
/// chequered part on its right, which is towards -y.
class OneShot : public ::testing::Test {
 protected:
  OneShot() {
    world::Observation view;
    view.camera = {160, 120, 150.0, 150.0, 79.5, 59.5};
    view.X_WC = LookAt({-1.0, 0.0, 0.0}, {0.0, 0.0, 0.0});
    view.frame.color = cv::Mat(120, 160, CV_8UC3, cv::Scalar::all(128));
    for (int v = 40; v < 80; v += 8) {
      for (int u = 88; u < 108; u += 8) {
        view.frame.color(cv::Rect(u, v, 4, 4)).setTo(cv::Scalar::all(255));
        view.frame.color(cv::Rect(u + 4, v + 4, 4, 4)).setTo(cv::Scalar::all(0));
      }
    }
    view.frame.depth = cv::Mat(120, 160, CV_32FC1, 1.3F);
    view.frame.depth(cv::Rect(50, 32, 60, 56)).setTo(1.0F);
    world::Detection detection;
    for (int v = 30; v < 90; ++v) {
      for (int u = 48; u < 112; ++u) detection.cluster.pixels.push_back(v * 160 + u);
    }
    detection.appearance.singletons = {{"oat", 0.45}, {"rice", 0.45}};
    detection.appearance.omega = 0.1;
    view.detections.push_back(detection);
    scene_.views.push_back(view);
    object_ = Between(0.48, 0.48);
    object_.id = 3;
    object_.extent_W.extend(Vector3d(-0.1, -0.1, -0.1));
    object_.extent_W.extend(Vector3d(0.1, 0.1, 0.1));
    object_.sightings = {{0, 0}};
  }

  static world::Look From(const Vector3d& p_WC) {
    world::Look look;
    look.kind = "aspect_graph";
    look.target = 3;
    look.X_WC = LookAt(p_WC, Vector3d::Zero());
    look.seconds = 15.0;
    look.feasible = true;
    return look;
  }

  std::optional<world::Look> Ask(const std::vector<world::Look>& looks) const {
    return OneShotLook(scene_, object_, {}, NineOfTen(), 0.97, {}, 5.0, looks);
  }

  world::SceneBelief scene_;
  world::ObjectBelief object_;
};

TEST_F(OneShot, LooksFromTheSideThatTheTilesVoteFor) {
  const world::Look left = From({-0.2, 1.0, 0.0});
  const world::Look right = From({-0.2, -1.0, 0.0});
  const std::optional<world::Look> look = Ask({left, right});
  ASSERT_TRUE(look);
  EXPECT_EQ(look->kind, "one_shot");
  EXPECT_LT((look->X_WC.translation() - right.X_WC.translation()).norm(), 1e-9);
  const double gain = Gain(object_, 0.97 * 0.9);
  EXPECT_NEAR(look->gain, gain, 1e-12);
  EXPECT_NEAR(look->score, gain / 20.0, 1e-12);
  EXPECT_EQ(look->checks.back().name, "one-shot vote");
}

TEST_F(OneShot, TakesTheNextSideWhereTheFirstCannotBeReached) {
  world::Look right = From({-0.2, -1.0, 0.0});
  right.feasible = false;
  const world::Look left = From({-0.2, 1.0, 0.0});
  const std::optional<world::Look> look = Ask({left, right});
  ASSERT_TRUE(look);
  EXPECT_GT(look->X_WC.translation().y(), 0.0);
  EXPECT_FALSE(Ask({right}));
}

TEST_F(OneShot, IsNotOfferedWhereTheClassIsSureOrThereIsNoPicture) {
  const std::vector<world::Look> looks{From({-0.2, -1.0, 0.0})};
  ASSERT_TRUE(Ask(looks));
  object_.masses.singletons = {{"oat", 0.95}, {"rice", 0.02}};
  object_.masses.omega = 0.03;
  EXPECT_FALSE(Ask(looks));
  object_ = Between(0.48, 0.48);
  EXPECT_FALSE(Ask(looks)) << "it was never seen";
}

}  // namespace
}  // namespace secondlook::apps
