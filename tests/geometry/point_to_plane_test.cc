#include "lib/geometry/point_to_plane.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::geometry {
namespace {

Eigen::Vector3d RandomVector(Rng* rng, double size) {
  return {rng->Uniform(-size, size), rng->Uniform(-size, size), rng->Uniform(-size, size)};
}

TEST(SolvePointToPlane, RepeatedStepsRecoverARandomMotion) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    Pose X_true = Pose::Identity();
    X_true.linear() = RotationFromVector(RandomVector(&rng, 0.1));
    X_true.translation() = RandomVector(&rng, 0.05);
    std::vector<PointPlanePair> pairs;
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector3d p = RandomVector(&rng, 0.2);
      pairs.push_back({p, X_true * p, RandomVector(&rng, 1.0).normalized(), 1.0});
    }
    Pose X = Pose::Identity();
    for (int round = 0; round < 10; ++round) {
      const PointPlaneStep step = SolvePointToPlane(pairs);
      EXPECT_EQ(step.constrained, 6);
      for (PointPlanePair& pair : pairs) pair.p_AP = step.X * pair.p_AP;
      X = step.X * X;
    }
    EXPECT_NEAR((X.translation() - X_true.translation()).norm(), 0.0, 1e-9) << "seed " << seed;
    EXPECT_NEAR(RotationDistance(X.linear(), X_true.linear()), 0.0, 1e-7) << "seed " << seed;
  }
}

TEST(SolvePointToPlane, LeavesAPlaneWhereItIsAlongItself) {
  Rng rng(1);
  std::vector<PointPlanePair> pairs;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-1, 1), rng.Uniform(-1, 1), 0.0);
    // The correspondence lies 3 cm above and, wrongly, 5 cm to the side.
    pairs.push_back({p, p + Eigen::Vector3d(0.05, 0.0, 0.03), Eigen::Vector3d::UnitZ(), 1.0});
  }
  const PointPlaneStep step = SolvePointToPlane(pairs);
  EXPECT_EQ(step.constrained, 3);  // height, roll and pitch
  EXPECT_NEAR(step.X.translation().x(), 0.0, 1e-9);
  EXPECT_NEAR(step.X.translation().z(), 0.03, 1e-9);
}

TEST(SolvePointToPlane, MakesNoStepFromFewerThanSixPairs) {
  std::vector<PointPlanePair> pairs(5);
  for (auto& pair : pairs) {
    pair = {Eigen::Vector3d::Random(), Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), 1.0};
  }
  const PointPlaneStep step = SolvePointToPlane(pairs);
  EXPECT_EQ(step.constrained, 0);
  EXPECT_TRUE(step.X.isApprox(Pose::Identity()));
}

/// A plane z = 0 whose points were measured 3 cm too low, each with a weight of 1e4 / 200.
std::vector<PointPlanePair> LowPlane() {
  Rng rng(2);
  std::vector<PointPlanePair> pairs;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-1, 1), rng.Uniform(-1, 1), -0.03);
    pairs.push_back({p, {p.x(), p.y(), 0.0}, Eigen::Vector3d::UnitZ(), 50.0});
  }
  return pairs;
}

TEST(SolvePointToPlane, LeavesWhatThePairsDoNotHoldToThePrior) {
  MotionPrior prior;
  prior.mean << 0.0, 0.0, 0.02, 0.01, -0.04, 0.0;
  prior.information.diagonal().setConstant(1.0);  // the pairs weigh 10,000 along z
  const PointPlaneStep step = SolvePointToPlane(LowPlane(), prior);
  EXPECT_EQ(step.constrained, 3);
  // What the prior says of the origin: along the plane it moves as the prior expects, …
  EXPECT_NEAR((step.X * Eigen::Vector3d::Zero()).x(), 0.01, 1e-4);
  EXPECT_NEAR((step.X * Eigen::Vector3d::Zero()).y(), -0.04, 1e-4);
  EXPECT_NEAR(RotationDistance(step.X.linear(), Eigen::Matrix3d::Identity()), 0.02, 1e-4);
  // … and across it by 10,000 against 1.
  EXPECT_NEAR((step.X * Eigen::Vector3d::Zero()).z(), 0.03 * 1e4 / (1e4 + 1.0), 1e-5);
}

TEST(SolvePointToPlane, LetsTheMoreCertainOfPairsAndPriorPrevail) {
  MotionPrior prior;  // it expects no motion at all
  prior.information.diagonal().setConstant(1e9);
  prior.information(5, 5) = 3e4;
  const PointPlaneStep step = SolvePointToPlane(LowPlane(), prior);
  EXPECT_NEAR((step.X * Eigen::Vector3d::Zero()).z(), 0.03 / 4.0, 1e-6);
  // 3 cm by two variances, 1 / 1e4 and 1 / 3e4.
  EXPECT_NEAR(step.sigmas, 0.03 / std::sqrt(1.0 / 1e4 + 1.0 / 3e4), 1e-3);
}

TEST(SolvePointToPlane, CountsWhatAllPairsMayBeShiftedByOnceHoweverManyTheyAre) {
  MotionPrior prior;  // it expects no motion at all
  prior.information.diagonal().setConstant(1e9);
  prior.information(5, 5) = 1.0 / (1.0 / 1e4 + 0.02 * 0.02);
  prior.common_shift = 0.02;
  // Across the plane the pairs' variance is 1 / 1e4 for themselves and 2 cm squared for the shift,
  // as much as the prior's: they meet halfway.
  const PointPlaneStep step = SolvePointToPlane(LowPlane(), prior);
  EXPECT_NEAR((step.X * Eigen::Vector3d::Zero()).z(), 0.03 / 2.0, 1e-6);
  EXPECT_NEAR(step.information(5, 5), prior.information(5, 5), 1e-3);
  // Of a turn a shift takes nothing.
  prior.common_shift = 0.0;
  EXPECT_NEAR(step.information(0, 0), SolvePointToPlane(LowPlane(), prior).information(0, 0), 1e-9);
}

TEST(SolvePointToPlane, MakesThePriorsMoveFromFewerThanSixPairs) {
  MotionPrior prior;
  prior.p_AO = {1.0, 2.0, 3.0};
  prior.mean << 0.0, 0.0, 0.002, 0.1, 0.0, 0.0;
  prior.information.setIdentity();
  const PointPlaneStep step = SolvePointToPlane({}, prior);
  EXPECT_EQ(step.constrained, 0);
  // The origin goes with O and turns about it: t + r x (0 - O).
  const Eigen::Vector3d origin = step.X * Eigen::Vector3d::Zero();
  EXPECT_NEAR((origin - Eigen::Vector3d(0.104, -0.002, 0.0)).norm(), 0.0, 1e-5);
}

TEST(SolvePointToPlane, RefusesAPriorThatLeavesADirectionOpen) {
  MotionPrior prior;
  prior.information.diagonal() << 1.0, 1.0, 1.0, 1.0, 1.0, 0.0;
  EXPECT_THROWS(SolvePointToPlane(LowPlane(), prior), InvalidArgument,
                "the information of the prior is not positive definite");
}

TEST(InformationAbout, ALeverMakesTheTurnCount) {
  // Only the z of a point O is known, one metre along x from Q: it moves by the turn about -y.
  Eigen::Matrix<double, 6, 6> known = Eigen::Matrix<double, 6, 6>::Zero();
  known(5, 5) = 4.0;
  const auto about = InformationAbout(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), known);
  EXPECT_DOUBLE_EQ(about(1, 1), 4.0);
  EXPECT_DOUBLE_EQ(about(5, 5), 4.0);
  EXPECT_DOUBLE_EQ(about(1, 5), -4.0);
  EXPECT_DOUBLE_EQ(about(0, 0), 0.0);
}

}  // namespace
}  // namespace secondlook::geometry
