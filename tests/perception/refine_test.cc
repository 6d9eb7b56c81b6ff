#include "lib/perception/refine.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/perception/synthetic_view.h"

namespace secondlook::perception {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// A can whose print alone tells its turn.
RecognitionModel PrintedCan() {
  world::ObjectModel can;
  can.name = "can";
  can.mesh = geometry::MakeCylinder(0.04, 0.11, 72, {1.0F, 1.0F, 1.0F});
  for (const Eigen::Vector3f& v : can.mesh.vertices) {
    const bool stripe = std::sin(3.0F * std::atan2(v.y(), v.x())) > 0.3F;
    can.mesh.vertex_colors.push_back(stripe ? Eigen::Vector3f(0.8F, 0.15F, 0.1F)
                                            : Eigen::Vector3f(0.9F, 0.9F, 0.85F));
  }
  return TrainModel(can);
}

class RefiningTogether : public ::testing::Test {
 protected:
  RefiningTogether()
      : can_(PrintedCan()),
        X_WM_(Upright(0.0, 0.0, 0.4)),
        turn_(TurnAbout({can_.center_M, Eigen::Vector3d::UnitZ()}, 6.0 * kDegree)) {
    X_WM_.translation().z() = 0.5 * 0.11;
    for (const double azimuth : {0.3, 1.4}) {
      scenes_.push_back(DrawView({{&can_, X_WM_}}, azimuth, true, &rng_));
    }
  }

  /// The can turned by X_MS in all views.
  std::vector<PlacedModel> Placed(const Pose& X_MS) const {
    std::vector<PlacedModel> placed;
    for (const SyntheticView& scene : scenes_) {
      placed.push_back({&scene.view, 0, scene.X_WC.inverse() * X_WM_ * X_MS});
    }
    return placed;
  }

  JointPose Refine(const std::vector<PlacedModel>& placed) {
    return RefineTogether(can_, placed, {0.006, 0.004}, 4, &rasteriser_);
  }

  /// How far the can is turned off [rad], by the answer to poses that are off by `turn_`.
  double ErrorOfTurn() {
    const Pose X_MS = Refine(Placed(turn_)).X_MS;
    return RotationDistance(Eigen::Matrix3d::Identity(), (turn_ * X_MS).linear());
  }

  Rng rng_{5};
  RecognitionModel can_;
  Pose X_WM_;
  Pose turn_;
  std::vector<SyntheticView> scenes_;
  geometry::DepthRasteriser rasteriser_;
};

TEST_F(RefiningTogether, TurnsACanToWhereItsPrintIs) { EXPECT_LT(ErrorOfTurn(), 1.0 * kDegree); }

TEST_F(RefiningTogether, LeavesTheTurnOfACanAloneWithoutColour) {
  const double known = Refine(Placed(turn_)).covariance(2, 2);
  for (SyntheticView& scene : scenes_) scene.view.color = cv::Mat();
  EXPECT_NEAR(ErrorOfTurn(), 6.0 * kDegree, 0.5 * kDegree);
  EXPECT_GT(Refine(Placed(turn_)).covariance(2, 2), 4.0 * known);
}

TEST_F(RefiningTogether, SharesWhatTheRegistrationErrsAmongTheViews) {
  std::vector<PlacedModel> placed = Placed(Pose::Identity());
  const JointPose before = Refine(placed);
  Pose shift_W = Pose::Identity();
  shift_W.translation() << 0.0, 0.004, 0.0;
  placed[1].X_CM = scenes_[1].X_WC.inverse() * shift_W * X_WM_;
  const JointPose after = Refine(placed);
  // In common it is half way back; what each view has for its own stays where it measured it.
  const Eigen::Vector3d moved_W =
      X_WM_.linear() * (after.X_MS.translation() - before.X_MS.translation());
  EXPECT_NEAR(moved_W.y(), -0.002, 0.0007);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    EXPECT_LT((after.X_CM[i].translation() - before.X_CM[i].translation()).norm(), 0.0013);
  }
}

}  // namespace
}  // namespace secondlook::perception
