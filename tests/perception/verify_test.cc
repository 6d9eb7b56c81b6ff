#include "lib/perception/verify.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/perception/refine.h"
#include "tests/perception/synthetic_view.h"

namespace secondlook::perception {
namespace {

const Eigen::Vector3f kRed(0.8F, 0.15F, 0.1F);
const Eigen::Vector3f kBlue(0.1F, 0.2F, 0.8F);
const Eigen::Vector3f kWhite(0.9F, 0.9F, 0.9F);

/// A view of an L on a table, and how hypotheses of it are judged.
class Verifying : public ::testing::Test {
 protected:
  Verifying()
      : ell_(TrainModel(MakeEll("ell", kRed, kWhite))),
        blue_(TrainModel(MakeEll("blue", kBlue, kBlue))),
        scene_(DrawView({{&ell_, Upright(0, 0, 0.8)}}, 0.3, true, &rng_)),
        X_CM_(scene_.X_WC.inverse() * Upright(0, 0, 0.8)) {}

  world::Verification Judge(const RecognitionModel& model, const Pose& X_CM) {
    const int inner = InnerPixels(scene_.view, 0, scene_.clusters[0]);
    return Verify(model, X_CM, scene_.view, 0, inner, {}, &rasteriser_, &score_);
  }

  /// X_CM_ moved by (x, y, z) of W [m].
  Pose Moved(double x, double y, double z) const {
    Pose X_CM = X_CM_;
    X_CM.translation() += scene_.X_WC.linear().transpose() * Eigen::Vector3d(x, y, z);
    return X_CM;
  }

  Rng rng_{1};
  RecognitionModel ell_;
  RecognitionModel blue_;
  SyntheticView scene_;
  Pose X_CM_;
  geometry::DepthRasteriser rasteriser_;
  double score_{};
};

TEST_F(Verifying, AcceptsTheTruePose) {
  const world::Verification v = Judge(ell_, X_CM_);
  EXPECT_TRUE(v.accepted) << v.reason;
  EXPECT_GT(v.quality, 0.95);
  EXPECT_GT(v.visible_fraction, 0.99);
  EXPECT_GT(v.color_agreement, 0.8);
  EXPECT_GT(score_, 0.95);
  EXPECT_EQ(v.see_through, 0);
}

TEST_F(Verifying, TheQualityIsThatOfEquation5) {
  const world::Verification v = Judge(ell_, Moved(0.01, 0.0, 0.0));
  const double covered = std::min(1.0, 1.0 * v.matching / v.cluster);
  EXPECT_NEAR(v.quality, 1.0 * v.matching / v.visible * covered * covered, 0.05);
  EXPECT_LT(v.matching, v.visible);
}

TEST_F(Verifying, SaysThatTheCameraSeesThroughWhatIsNotThere) {
  const world::Verification v = Judge(ell_, Moved(0.06, 0.06, 0.0));
  EXPECT_FALSE(v.accepted);
  EXPECT_THAT(v.reason, ::testing::HasSubstr("the camera sees through"));
}

TEST_F(Verifying, RejectsTheRightShapeInTheWrongColour) {
  const world::Verification v = Judge(blue_, X_CM_);
  EXPECT_FALSE(v.accepted);
  EXPECT_THAT(v.reason, ::testing::HasSubstr("its colours agree by"));
}

TEST_F(Verifying, DoesNotHoldAgainstAPoseWhatANearerThingHides) {
  const double visible_before = Judge(ell_, X_CM_).visible;
  // Something 20 cm before the left half of the view of it, in no cluster.
  const auto middle = static_cast<int>(scene_.view.camera.Project(X_CM_ * ell_.center_M)->x());
  for (int y = 0; y < scene_.view.depth.rows; ++y) {
    for (int x = 0; x < middle; ++x) {
      scene_.view.depth.at<float>(y, x) = 0.6F;
      scene_.view.labels.at<int>(y, x) = -1;
    }
  }
  world::Cluster& cluster = scene_.clusters[0];
  std::erase_if(cluster.pixels, [&](int pixel) { return pixel % 640 < middle; });
  const world::Verification v = Judge(ell_, X_CM_);
  EXPECT_TRUE(v.accepted) << v.reason;
  EXPECT_LT(v.visible, 0.8 * visible_before);
  EXPECT_LT(v.visible_fraction, 0.8);
}

TEST_F(Verifying, AMissingMeasurementIsNeitherForNorAgainst) {
  for (int y = 0; y < scene_.view.depth.rows; ++y) {
    for (int x = 0; x < scene_.view.depth.cols; x += 2) {
      scene_.view.depth.at<float>(y, x) = NAN;
    }
  }
  const world::Verification v = Judge(ell_, X_CM_);
  EXPECT_NEAR(v.visible_fraction, 0.5, 0.1);
  EXPECT_GT(1.0 * v.matching / v.visible, 0.95);
}

TEST_F(Verifying, AcceptsNothingOfWhichNothingIsMeasured) {
  scene_.view.depth.setTo(NAN);
  const world::Verification v = Judge(ell_, X_CM_);
  EXPECT_FALSE(v.accepted);
  EXPECT_EQ(v.visible, 0);
  EXPECT_EQ(score_, 0.0);
  EXPECT_THAT(v.reason, ::testing::HasSubstr("only 0 pixels of it are visible"));
}

TEST_F(Verifying, SaysWhenAnObjectHangsInTheAir) {
  scene_.view.plane_C.offset -= 0.05;
  const world::Verification v = Judge(ell_, X_CM_);
  EXPECT_FALSE(v.accepted);
  EXPECT_THAT(v.reason, ::testing::HasSubstr("its lowest point is 50 mm above"));
}

TEST_F(Verifying, OutsideTheImageThereIsNothingToSee) {
  Pose X_CM = X_CM_;
  X_CM.translation().x() += 5.0;
  EXPECT_FALSE(Judge(ell_, X_CM).accepted);
  X_CM = X_CM_;
  X_CM.translation().z() = -1.0;
  EXPECT_FALSE(Judge(ell_, X_CM).accepted);
}

TEST_F(Verifying, RefusesWhatLiesMostlyBesideThePicture) {
  // Its middle 20 pixels beside the left border: what shows of it could be anything.
  Pose X_CM = X_CM_;
  const Eigen::Vector3d center_C = X_CM * ell_.center_M;
  const geometry::CameraModel& camera = scene_.view.camera;
  X_CM.translation().x() += (-20.0 - camera.cx) / camera.fx * center_C.z() - center_C.x();
  const world::Verification v = Judge(ell_, X_CM);
  EXPECT_FALSE(v.accepted);
  EXPECT_THAT(v.reason, ::testing::HasSubstr("of it lies within the picture (at least 50 %)"));
}

TEST_F(Verifying, RefinementBringsAPoseBackFromCentimetresAway) {
  for (int seed = 0; seed < 8; ++seed) {
    Rng rng(static_cast<std::uint64_t>(seed));
    Pose X_CM = Moved(rng.Uniform(-0.008, 0.008), rng.Uniform(-0.008, 0.008), 0.0);
    X_CM = X_CM * TurnAbout({ell_.center_M, Eigen::Vector3d::UnitZ()}, rng.Uniform(-0.1, 0.1));
    const Pose X_refined = RefinePose(ell_, X_CM, scene_.view, 0, 8, &rasteriser_);
    EXPECT_LT((X_refined * ell_.center_M - X_CM_ * ell_.center_M).norm(), 0.003) << seed;
    EXPECT_LT(RotationDistance(X_refined.linear(), X_CM_.linear()), 0.03) << seed;
  }
}

}  // namespace
}  // namespace secondlook::perception
