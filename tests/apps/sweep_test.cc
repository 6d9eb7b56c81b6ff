// Sweeps by the simulated arm over a box.

#include "apps/sweep.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "sim/sim_striper.h"
#include "tests/sim/rig.h"
#include "tests/support/expect_throws.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

constexpr double kSide = 0.1;  // [m] of the box

/// A robot, a box before it with its top at 0.75 m, and a sweep over that.
struct Rig {
  std::shared_ptr<sim::SimulatedRobot> simulated;
  Pose X_WB;
  Pose X_WBox;  ///< Its centre.
  planning::PlannedSweep plan;

  explicit Rig(const sim::NoiseConfig& noise, int held = 100) {
    sim::SimConfig config;
    config.noise = noise;
    config.arm.emplace().urdf = "sim/robots/arm.urdf";
    config.arm->striper.emplace().held = held;
    sim::Scene scene = sim::FreeScene();
    X_WB = ToPose(Pose2{0.0, 0.0, scene.robot.yaw_deg / 180.0 * M_PI});
    X_WBox = X_WB * Eigen::Translation3d(0.75, 0.0, 0.75 - kSide / 2);
    sim::SceneBox box;
    box.size = Vector3d::Constant(kSide);
    box.position = X_WBox * Vector3d(0.0, 0.0, -kSide / 2);
    box.yaw_deg = scene.robot.yaw_deg;
    scene.boxes.push_back(box);
    simulated = sim::MakeShared(scene, config, 3);

    const Eigen::VectorXd q = robot().arm->State().q;
    const planning::ArmCollision collision(simulated->hand->arm, X_WB, {});
    plan = planning::PlanSweep(
        planning::SweepOver(X_WBox * Vector3d(0.0, 0.0, kSide / 2),
                            X_WB.linear() * Vector3d(1.0, 0.0, -1.0),
                            X_WB.linear() * Vector3d::UnitY(), 0.2, robot().striper->info()),
        {robot().arm->info().joints, X_WB, *simulated->X_EL, q}, collision, 1);
    EXPECT_EQ(plan.outcome, planning::SweepOutcome::kFound) << plan.reason;
  }

  hal::Robot& robot() const { return simulated->robot; }
  bool lit() const { return simulated->world->striper()->lit(); }

  Swept Run(const StopRequest& stop = [] { return false; }) const {
    return RunSweep(plan, {simulated->hand->arm, *simulated->X_EL}, X_WB, stop, &robot());
  }

  /// How far the points of `scan` that are near the box lie from its surface at most [m].
  double FarthestFromBox(const world::RangeScan& scan, int* near) const {
    double farthest = 0.0;
    *near = 0;
    for (const Vector3d& p_W : scan.points_W) {
      const Vector3d p = (X_WBox.inverse() * p_W).cwiseAbs();
      if (p.maxCoeff() > 0.6 * kSide) continue;
      ++*near;
      farthest = std::max(farthest, std::abs(p.maxCoeff() - kSide / 2));
    }
    return farthest;
  }
};

TEST(Sweep, BringsTheSurfaceThatTheLaserPassedOver) {
  const Rig rig(sim::NoiseConfig::None());
  const Swept swept = rig.Run();
  EXPECT_EQ(swept.motion.kind, DriveOutcome::Kind::kReached) << swept.motion.reason;
  EXPECT_EQ(swept.lost, 0U);
  EXPECT_EQ(swept.without_place, 0U);
  EXPECT_NEAR(swept.lines, 50 * rig.plan.sweep.seconds(), 3);
  EXPECT_EQ(swept.scan.lines.size(), static_cast<std::size_t>(swept.lines));
  EXPECT_NO_THROW(world::Check(swept.scan));
  int near = 0;
  EXPECT_LE(rig.FarthestFromBox(swept.scan, &near), 2e-5);
  EXPECT_GT(near, 40'000);
  EXPECT_FALSE(rig.lit());
}

TEST(Sweep, IsAsGoodAsTheArmAndTheMountingOfTheLaser) {
  const Rig rig((sim::NoiseConfig()));
  const Swept swept = rig.Run();
  EXPECT_EQ(swept.without_place, 0U);
  int near = 0;
  const double farthest = rig.FarthestFromBox(swept.scan, &near);
  EXPECT_LE(farthest, 0.01);
  EXPECT_GE(farthest, 1e-4);
  EXPECT_GT(near, 40'000);
}

TEST(Sweep, KeepsWhatItHasWhenItIsStopped) {
  const Rig rig(sim::NoiseConfig::None());
  const Time half = rig.robot().clock->Now() +
                    Seconds(rig.plan.approach.seconds() + 0.5 * rig.plan.sweep.seconds());
  const Swept swept = rig.Run([&] { return rig.robot().clock->Now() >= half; });
  EXPECT_EQ(swept.motion.kind, DriveOutcome::Kind::kStopped);
  EXPECT_THAT(swept.motion.reason, ::testing::HasSubstr("stopped on request"));
  EXPECT_NEAR(swept.lines, 25 * rig.plan.sweep.seconds(), 10);
  int near = 0;
  EXPECT_LE(rig.FarthestFromBox(swept.scan, &near), 2e-5);
  EXPECT_GT(near, 15'000);
  EXPECT_FALSE(rig.lit());
  EXPECT_EQ(rig.robot().arm->Status().phase, hal::MotionPhase::kStopped);
}

TEST(Sweep, KeepsWhatItHasWhenSomebodyElseStopsTheRobot) {
  const Rig rig(sim::NoiseConfig::None());
  const Time half = rig.robot().clock->Now() +
                    Seconds(rig.plan.approach.seconds() + 0.5 * rig.plan.sweep.seconds());
  const Swept swept = rig.Run([&] {
    if (rig.robot().clock->Now() >= half) rig.robot().Stop();
    return false;
  });
  EXPECT_EQ(swept.motion.kind, DriveOutcome::Kind::kStopped);
  EXPECT_GT(swept.lines, 0);
  EXPECT_FALSE(rig.lit());
}

TEST(Sweep, BringsNothingAndNoLightWhenItIsStoppedBefore) {
  const Rig rig(sim::NoiseConfig::None());
  bool shone = false;
  const Time soon = rig.robot().clock->Now() + Seconds(0.5 * rig.plan.approach.seconds());
  const Swept swept = rig.Run([&] {
    shone = shone || rig.lit();
    return rig.robot().clock->Now() >= soon;
  });
  EXPECT_EQ(swept.motion.kind, DriveOutcome::Kind::kStopped);
  EXPECT_TRUE(swept.scan.empty());
  EXPECT_FALSE(shone);
}

TEST(Sweep, StopsTheArmWhenTheLaserIsLost) {
  const Rig rig(sim::NoiseConfig::None());
  const Time half = rig.robot().clock->Now() +
                    Seconds(rig.plan.approach.seconds() + 0.5 * rig.plan.sweep.seconds());
  const auto lose = [&] {
    if (rig.robot().clock->Now() >= half) {
      static_cast<sim::SimStriper*>(rig.robot().striper.get())->Lose();
    }
    return false;
  };
  EXPECT_THROWS(rig.Run(lose), DeviceError, "striper 'striper': the device is lost");
  EXPECT_FALSE(rig.lit());
  for (int i = 0; i < 100; ++i) rig.simulated->world->Step();
  EXPECT_EQ(rig.robot().arm->Status().phase, hal::MotionPhase::kStopped);
}

TEST(Sweep, IsTheSameForTheSameSeed) {
  const Rig a((sim::NoiseConfig()));
  const Rig b((sim::NoiseConfig()));
  const world::RangeScan first = a.Run().scan;
  const world::RangeScan second = b.Run().scan;
  ASSERT_EQ(first.points_W.size(), second.points_W.size());
  for (std::size_t i = 0; i < first.points_W.size(); ++i) {
    ASSERT_EQ(first.points_W[i], second.points_W[i]);
  }
}

}  // namespace
}  // namespace secondlook::apps
