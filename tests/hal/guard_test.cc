#include "lib/hal/guard.h"

#include <gtest/gtest.h>

#include "tests/support/expect_throws.h"
#include "tests/support/fake_robot.h"

namespace secondlook::hal {
namespace {

using ::testing::HasSubstr;

GuardConfig WithWorkspace() {
  GuardConfig config;
  config.workspace = Workspace{{-1.0, 2.0}, {-1.0, 1.0}};
  return config;
}

/// A fake robot with an arm, behind a guard.
struct Guarded {
  explicit Guarded(const GuardConfig& config = {})
      : guard(config), robot(guard.Protect(testing::MakeFakeRobotWithArm(&world))) {
    world.base_takes = Seconds(10.0);
    world.head_takes = Seconds(10.0);
    world.arm_takes = Seconds(10.0);
  }

  void StartAll() {
    robot.base->Start({{{1.0, 0.0, 0.0}}});
    robot.head->Start({0.5, 0.0});
    robot.arm->Start({{{0.0, Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()}}});
  }

  testing::FakeWorld world;
  Guard guard;
  Robot robot;
};

class FakeStriper : public LaserStriper {
 public:
  explicit FakeStriper(bool* lit) : lit_(lit) {}
  const StriperInfo& info() const override { return info_; }
  void On() override { *lit_ = true; }
  void Off() noexcept override { *lit_ = false; }
  std::vector<ScanLine> Take() override { return {}; }
  std::uint64_t lost() const override { return 0; }

 private:
  bool* lit_;
  StriperInfo info_;
};

TEST(Guard, KeepsTheLaserDarkWhileAStopHolds) {
  bool lit = false;
  testing::FakeWorld world;
  Guard guard({});
  Robot robot = testing::MakeFakeRobotWithArm(&world);
  robot.striper = std::make_unique<FakeStriper>(&lit);
  robot = guard.Protect(std::move(robot));
  robot.striper->On();
  EXPECT_TRUE(lit);
  guard.Hold("a command");
  robot.Stop();
  EXPECT_FALSE(lit);
  robot.striper->On();
  EXPECT_FALSE(lit);
  guard.Clear();
  robot.striper->On();
  EXPECT_TRUE(lit);
}

TEST(Guard, LetsMotionsThroughThatBreakNoLimit) {
  Guarded guarded(WithWorkspace());
  guarded.StartAll();
  EXPECT_EQ(guarded.world.base_starts, 1);
  EXPECT_EQ(guarded.world.head_starts, 1);
  EXPECT_EQ(guarded.world.arm_starts, 1);
  EXPECT_EQ(guarded.robot.base->Status().phase, MotionPhase::kMoving);
}

TEST(Guard, StartsNothingWhileAStopHoldsAndSaysWhy) {
  Guarded guarded;
  guarded.guard.Hold("a command: 'hand in the way'");
  guarded.guard.Hold("another");
  guarded.StartAll();
  EXPECT_EQ(guarded.world.base_starts + guarded.world.head_starts + guarded.world.arm_starts, 0);
  for (const MotionStatus& status :
       {guarded.robot.base->Status(), guarded.robot.head->Status(), guarded.robot.arm->Status()}) {
    EXPECT_EQ(status.phase, MotionPhase::kStopped);
    EXPECT_EQ(status.reason, "a protective stop holds: a command: 'hand in the way'");
  }
}

TEST(Guard, HoldsUntilTheStopIsCleared) {
  Guarded guarded;
  guarded.guard.Hold("a test");
  guarded.world.now += Seconds(1e6);
  guarded.StartAll();
  EXPECT_EQ(guarded.world.base_starts, 0) << "time clears nothing";
  guarded.guard.Clear();
  EXPECT_EQ(guarded.guard.why(), "");
  guarded.StartAll();
  EXPECT_EQ(guarded.world.base_starts, 1);
  EXPECT_EQ(guarded.robot.base->Status().phase, MotionPhase::kMoving);
}

/// A base during whose Start() a stop comes from another thread.
class StoppedWhileStarting : public testing::FakeBase {
 public:
  StoppedWhileStarting(testing::FakeWorld* world, Guard* guard) : FakeBase(world), guard_(guard) {}
  void Start(const BasePath& path) override {
    guard_->Hold("a test");
    Stop();  // too early: it does not move yet
    FakeBase::Start(path);
  }

 private:
  Guard* guard_;
};

TEST(Guard, LosesNoStopThatComesWhileAMotionIsStarted) {
  testing::FakeWorld world;
  Guard guard({});
  Robot robot = testing::MakeFakeRobot(&world);
  robot.base = std::make_unique<StoppedWhileStarting>(&world, &guard);
  robot = guard.Protect(std::move(robot));
  robot.base->Start({{{1.0, 0.0, 0.0}}});
  EXPECT_EQ(world.base_status.phase, MotionPhase::kStopped);
}

TEST(Guard, FailsAMotionOutOfTheWorkspaceBeforeItBegins) {
  Guarded guarded(WithWorkspace());
  guarded.robot.base->Start({{{1.0, 0.0, 0.0}, {2.5, 0.5, 0.0}}});
  EXPECT_EQ(guarded.world.base_starts, 0);
  const MotionStatus status = guarded.robot.base->Status();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_EQ(status.reason, "its way leads through (2.50, 0.50) m, out of safety.limits.workspace");
}

TEST(Guard, StopsABaseThatLeavesTheWorkspaceByItself) {
  Guarded guarded(WithWorkspace());
  guarded.robot.base->Start({{{1.0, 0.0, 0.0}}});
  guarded.world.X_WB = {2.3, 0.0, 0.0};
  guarded.robot.base->Status();
  EXPECT_EQ(guarded.world.base_stops, 1);
  const MotionStatus status = guarded.robot.base->Status();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_EQ(status.reason, "it is at (2.30, 0.00) m, 0.30 m out of safety.limits.workspace");
}

TEST(Guard, StopsABaseThatDrivesFasterThanItMay) {
  GuardConfig config;
  config.base_speed = 0.5;
  Guarded guarded(config);
  guarded.world.base_speed = 0.8;
  guarded.robot.base->Start({{{1.0, 0.0, 0.0}}});
  MotionStatus status;
  for (int i = 0; i < 20; ++i) {
    status = guarded.robot.base->Status();
    guarded.world.Advance(Seconds(0.05));
  }
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_EQ(status.reason, "it drives at 0.80 m/s, and safety.limits.base_speed allows 0.50");
}

TEST(Guard, LetsABaseDriveAsFastAsItMay) {
  GuardConfig config;
  config.base_speed = 0.5;
  Guarded guarded(config);
  guarded.world.base_speed = 0.5;
  guarded.robot.base->Start({{{1.0, 0.0, 0.0}}});
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(guarded.robot.base->Status().phase, MotionPhase::kMoving);
    guarded.world.Advance(Seconds(0.05));
  }
}

/// A robot whose arm reaches as many metres along x as its first joint has radians, in a workspace
/// that ends at 1 m, behind a guard.
class GuardedArm : public ::testing::Test {
 protected:
  GuardedArm() {
    world_.arm_takes = Seconds(10.0);
    robot_ = guard_.Protect(testing::MakeFakeRobotWithArm(&world_), [](const Eigen::VectorXd& q) {
      return Eigen::AlignedBox3d(Eigen::Vector3d(0.0, -0.1, 0.0), Eigen::Vector3d(q[0], 0.1, 0.5));
    });
  }

  static GuardConfig Config() {
    GuardConfig config;
    config.arm_workspace = ArmWorkspace{{-0.5, 1.0}, {-0.5, 0.5}, {-0.1, 1.0}};
    return config;
  }

  /// From standstill to standstill, by way of these positions of the first joint.
  void Start(std::initializer_list<double> positions) {
    JointTrajectory trajectory;
    for (const double position : positions) {
      const auto seconds = static_cast<double>(trajectory.knots.size());
      trajectory.knots.push_back(
          {seconds, Eigen::Vector2d(position, 0.0), Eigen::Vector2d::Zero()});
    }
    robot_.arm->Start(trajectory);
  }

  testing::FakeWorld world_;
  Guard guard_{Config()};
  Robot robot_;
};

TEST_F(GuardedArm, MovesWithinItsWorkspace) {
  Start({0.2, 0.99, 0.5});
  EXPECT_EQ(world_.arm_starts, 1);
  world_.q[0] = 0.99;
  EXPECT_EQ(robot_.arm->Status().phase, MotionPhase::kMoving);
}

TEST_F(GuardedArm, BeginsNoMotionOutOfItsWorkspaceAlsoWhenItEndsWithin) {
  Start({0.2, 1.3, 0.5});
  EXPECT_EQ(world_.arm_starts, 0);
  const MotionStatus status = robot_.arm->Status();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_EQ(status.reason,
            "its way leads out of safety.limits.arm_workspace: after 1.00 s it reaches from (0.00, "
            "-0.10, 0.00) to (1.30, 0.10, 0.50) m in B, 0.30 m too far");
}

TEST_F(GuardedArm, MayComeBackFromOutsideButGoNoFarther) {
  Start({1.2, 1.25, 0.5});
  EXPECT_EQ(world_.arm_starts, 0);
  Start({1.2, 0.5});
  EXPECT_EQ(world_.arm_starts, 1);
  world_.q[0] = 1.2;
  EXPECT_EQ(robot_.arm->Status().phase, MotionPhase::kMoving);
}

TEST_F(GuardedArm, IsStoppedWhenItLeavesItsWorkspaceByItself) {
  Start({0.2, 0.9});
  world_.q[0] = 1.05;
  robot_.arm->Status();
  EXPECT_EQ(world_.arm_stops, 1);
  const MotionStatus status = robot_.arm->Status();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_EQ(status.reason,
            "it reaches from (0.00, -0.10, 0.00) to (1.05, 0.10, 0.50) m in B, 0.05 m out of "
            "safety.limits.arm_workspace");
}

TEST(Guard, RefusesAWorkspaceOfAnArmThatThereIsNot) {
  testing::FakeWorld world;
  GuardConfig config;
  config.arm_workspace.emplace();
  Guard guard(config);
  EXPECT_THROWS(
      guard.Protect(testing::MakeFakeRobot(&world)), ConfigError,
      "safety.limits.arm_workspace is given, but the robot has no arm whose shape is known");
}

TEST(Guard, RefusesDevicesThatAreConfiguredFasterThanTheyMayBe) {
  testing::FakeWorld world;
  const auto protect = [&](double GuardConfig::*speed, double value) {
    GuardConfig config;
    config.*speed = value;
    Guard guard(config);
    guard.Protect(testing::MakeFakeRobotWithArm(&world));
  };
  EXPECT_THROWS(protect(&GuardConfig::base_speed, 0.3), ConfigError,
                "base 'wheels' goes at 0.5 m/s, and safety.limits.base_speed allows 0.3: lower the "
                "speed in the configuration of its driver");
  EXPECT_THROWS(protect(&GuardConfig::base_turn_rate_deg, 30.0), ConfigError,
                "base 'wheels' goes at 57.3 deg/s");
  EXPECT_THROWS(protect(&GuardConfig::head_speed_deg, 30.0), ConfigError,
                "pan-tilt 'neck' goes at 57.3 deg/s");
  EXPECT_THROWS(protect(&GuardConfig::arm_speed_deg, 30.0), ConfigError,
                "arm 'limb', joint 'lift', goes at 57.3 deg/s");
}

TEST(Guard, KnowsWhichMotionLapsesForNobodyAsksAboutIt) {
  Guarded guarded;
  guarded.robot.head->Start({0.5, 0.0});
  guarded.world.Advance(Seconds(1.9));
  EXPECT_EQ(guarded.guard.Lapsed(), "");
  guarded.robot.head->Status();  // which renews it
  guarded.world.Advance(Seconds(1.9));
  EXPECT_EQ(guarded.guard.Lapsed(), "");
  guarded.world.Advance(Seconds(0.2));
  EXPECT_EQ(guarded.guard.Lapsed(), "pan-tilt 'neck'");
}

TEST(Guard, LetsWhatHasEndedLapseNoMore) {
  Guarded guarded;
  guarded.robot.head->Start({0.5, 0.0});
  guarded.world.Advance(Seconds(10.0));
  EXPECT_EQ(guarded.robot.head->Status().phase, MotionPhase::kReached);
  guarded.world.Advance(Seconds(100.0));
  EXPECT_EQ(guarded.guard.Lapsed(), "");
}

TEST(Guard, LetsNoStateThroughThatIsNotFinite) {
  Guarded guarded;
  EXPECT_NO_THROW(guarded.robot.base->State());
  guarded.world.X_WB.yaw = NAN;
  guarded.world.angles.pan = INFINITY;
  guarded.world.q[1] = NAN;
  EXPECT_THROWS(guarded.robot.base->State(), ProtocolError,
                "base 'wheels': its pose is not finite; check what measures it");
  EXPECT_THROWS(guarded.robot.head->State(), ProtocolError,
                "pan-tilt 'neck': its angles are not finite");
  EXPECT_THROWS(guarded.robot.arm->State(), ProtocolError,
                "arm 'limb': its joint angles are missing or not finite");
}

TEST(GuardConfig, NamesWhatIsWrong) {
  const auto refused = [](const std::function<void(GuardConfig*)>& change) {
    GuardConfig config;
    change(&config);
    config.Validate();
  };
  EXPECT_NO_THROW(GuardConfig{}.Validate());
  EXPECT_THROWS(refused([](GuardConfig* c) { c->base_speed = -0.1; }), ConfigError,
                "base_speed = -0.1 must be at least 0");
  EXPECT_THROWS(refused([](GuardConfig* c) { c->arm_speed_deg = NAN; }), ConfigError,
                "arm_speed_deg = nan must be at least 0");
  EXPECT_THROWS(refused([](GuardConfig* c) { c->lapse_seconds = 0.0; }), ConfigError,
                "lapse_seconds = 0 must be 0.2 to 60");
  EXPECT_THROWS(refused([](GuardConfig* c) {
                  c->workspace = Workspace{{1.0, -1.0}, {0.0, 1.0}};
                }),
                ConfigError, "x = [1, -1] must be [from, to], finite, with from < to");
  EXPECT_THROWS(refused([](GuardConfig* c) {
                  c->arm_workspace = ArmWorkspace{{-1.0, 1.0}, {-1.0, 1.0}, {0.5, NAN}};
                }),
                ConfigError, "z = [0.5, nan] must be [from, to], finite, with from < to");
}

/// A base whose stop does nothing.
class DeafBase : public testing::FakeBase {
 public:
  using FakeBase::FakeBase;
  void Stop() noexcept override {}
};

TEST(Robot, StopsEachActuatorAlsoWhenOneOfThemDoesNotListen) {
  testing::FakeWorld world;
  Robot robot = testing::MakeFakeRobotWithArm(&world);
  robot.base = std::make_unique<DeafBase>(&world);
  robot.Stop();
  EXPECT_EQ(world.head_stops, 1);
  EXPECT_EQ(world.arm_stops, 1);
}

}  // namespace
}  // namespace secondlook::hal
