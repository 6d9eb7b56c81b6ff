#include "lib/geometry/point_to_plane.h"

#include <gtest/gtest.h>

#include "lib/common/rng.h"

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

}  // namespace
}  // namespace secondlook::geometry
