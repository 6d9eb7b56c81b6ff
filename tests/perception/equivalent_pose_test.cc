#include "lib/perception/equivalent_pose.h"

#include <numbers>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

Pose Random(Rng* rng) {
  Pose X = Pose::Identity();
  X.linear() = RotationFromVector({rng->Uniform(-2, 2), rng->Uniform(-2, 2), rng->Uniform(-2, 2)});
  X.translation() << rng->Uniform(-1, 1), rng->Uniform(-1, 1), rng->Uniform(-1, 1);
  return X;
}

TEST(NearestEquivalent, TakesBackAnyTurnAboutAContinuousAxis) {
  Symmetry can;
  can.motions = {{Pose::Identity(), true}};
  can.axis = Axis{Vector3d(0.1, 0.0, 0.0), Vector3d::UnitZ()};
  can.axis_keeps_color = true;
  Rng rng(1);
  for (int i = 0; i < 20; ++i) {
    const Pose X_CA = Random(&rng);
    const Pose X_CB = X_CA * TurnAbout(*can.axis, rng.Uniform(-kPi, kPi));
    EXPECT_TRUE(NearestEquivalent(X_CA, X_CB, can, true).isApprox(X_CA, 1e-9));
  }
}

TEST(NearestEquivalent, TurnsNothingThatColourTells) {
  Symmetry printed;
  printed.motions = {{Pose::Identity(), true},
                     {TurnAbout({Vector3d::Zero(), Vector3d::UnitZ()}, kPi), false}};
  const Pose X_CA = Pose::Identity();
  const Pose X_CB = printed.motions[1].X_MS;
  EXPECT_TRUE(NearestEquivalent(X_CA, X_CB, printed, true).isApprox(X_CB, 1e-12));
  EXPECT_TRUE(NearestEquivalent(X_CA, X_CB, printed, false).isApprox(X_CA, 1e-12));
}

TEST(NearestEquivalent, IsAsFarAsTheDistanceUpToSymmetrySays) {
  Symmetry can;
  can.motions = {{Pose::Identity(), true},
                 {TurnAbout({Vector3d::Zero(), Vector3d::UnitX()}, kPi), true}};
  can.axis = Axis{Vector3d::Zero(), Vector3d::UnitZ()};
  can.axis_keeps_color = true;
  Rng rng(2);
  for (int i = 0; i < 20; ++i) {
    const Pose X_CA = Random(&rng);
    const Pose X_CB = Random(&rng);
    const Pose X_CE = NearestEquivalent(X_CA, X_CB, can, true);
    EXPECT_NEAR(RotationDistance(X_CA.linear(), X_CE.linear()),
                DistanceUpToSymmetry(X_CA, X_CB, can, Vector3d::Zero(), true).rotation, 1e-6);
  }
}

}  // namespace
}  // namespace secondlook::perception
