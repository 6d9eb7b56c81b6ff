#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <ostream>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "lib/common/clock.h"
#include "lib/common/error.h"
#include "lib/hal/base.h"
#include "tests/support/expect_throws.h"

namespace secondlook::hal {

/// A base to be held to what lib/hal/base.h promises, and the clock of its robot. The floor must be
/// free for 1.5 m around it.
struct BaseRig {
  Clock* clock{};
  Base* base{};
  std::shared_ptr<void> owner;  ///< Keeps both alive; of a type that only the factory knows.
};

/// Makes the same kind of base anew for each test.
struct BaseFactory {
  std::string name;  ///< Of the backend, in the names of the tests.
  std::function<BaseRig()> make;

  friend void PrintTo(const BaseFactory& factory, std::ostream* out) { *out << factory.name; }
};

class BaseContract : public ::testing::TestWithParam<BaseFactory> {
 protected:
  BaseContract() : rig_(GetParam().make()), clock_(*rig_.clock), base_(*rig_.base) {}

  void Wait(double seconds) { clock_.SleepUntil(clock_.Now() + Seconds(seconds)); }

  /// Waits for the end of the motion, a minute at most.
  MotionStatus WaitForEnd() {
    for (int i = 0; i < 1200 && base_.Status().phase == MotionPhase::kMoving; ++i) Wait(0.05);
    return base_.Status();
  }

  /// The floor pose that lies `forward` and `left` [m] of where the base is, turned by `turn`.
  Pose2 Beside(double forward, double left, double turn) {
    const Pose2 X_WB = base_.State().X_WB;
    return {X_WB.x + forward * std::cos(X_WB.yaw) - left * std::sin(X_WB.yaw),
            X_WB.y + forward * std::sin(X_WB.yaw) + left * std::cos(X_WB.yaw),
            WrapAngle(X_WB.yaw + turn)};
  }

  void ExpectAt(const Pose2& goal) {
    const Pose2 X_WB = base_.State().X_WB;
    EXPECT_LE(std::hypot(X_WB.x - goal.x, X_WB.y - goal.y), 0.1);
    EXPECT_LE(std::abs(WrapAngle(X_WB.yaw - goal.yaw)), 5.0 / 180.0 * M_PI);
  }

  void ExpectStandsStill() {
    const Pose2 before = base_.State().X_OB;
    Wait(0.5);
    const Pose2 after = base_.State().X_OB;
    EXPECT_LE(std::hypot(after.x - before.x, after.y - before.y), 0.001);
    EXPECT_LE(std::abs(WrapAngle(after.yaw - before.yaw)), 0.001);
  }

  BaseRig rig_;
  Clock& clock_;
  Base& base_;
};

TEST_P(BaseContract, InfoIsValid) {
  EXPECT_FALSE(base_.info().name.empty());
  EXPECT_GT(base_.info().radius, 0.0);
  EXPECT_GT(base_.info().height, 0.0);
  EXPECT_GT(base_.info().speed, 0.0);
  EXPECT_GT(base_.info().turn_rate, 0.0);
}

TEST_P(BaseContract, IsIdleUntilSomethingIsStarted) {
  EXPECT_EQ(base_.Status().phase, MotionPhase::kIdle);
  ExpectStandsStill();
}

TEST_P(BaseContract, StartReturnsAtOnce) {
  const Time before = clock_.Now();
  base_.Start({{Beside(1.0, 0.0, 0.0)}});
  EXPECT_LT(clock_.Now() - before, Seconds(0.05));
  EXPECT_EQ(base_.Status().phase, MotionPhase::kMoving);
}

TEST_P(BaseContract, ReachesItsGoalAndStandsStill) {
  const Pose2 goal = Beside(0.8, 0.5, 1.2);
  base_.Start({{goal}});
  const MotionStatus status = WaitForEnd();
  EXPECT_EQ(status.phase, MotionPhase::kReached) << status.reason;
  EXPECT_EQ(status.reason, "");
  ExpectAt(goal);
  ExpectStandsStill();
  ExpectAt(goal);
}

TEST_P(BaseContract, PassesItsWaypoints) {
  const Pose2 corner = Beside(0.8, 0.0, 0.0);
  const Pose2 goal = Beside(0.8, 0.8, 3.0);
  base_.Start({{corner, goal}});
  double nearest = std::numeric_limits<double>::infinity();
  while (base_.Status().phase == MotionPhase::kMoving) {
    Wait(0.05);
    const Pose2 X_WB = base_.State().X_WB;
    nearest = std::min(nearest, std::hypot(X_WB.x - corner.x, X_WB.y - corner.y));
  }
  EXPECT_EQ(base_.Status().phase, MotionPhase::kReached);
  EXPECT_LE(nearest, 0.15);
  ExpectAt(goal);
}

TEST_P(BaseContract, AGoalWhereItStandsIsReached) {
  const Pose2 goal = Beside(0.0, 0.0, 0.0);
  base_.Start({{goal}});
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
  ExpectAt(goal);
}

TEST_P(BaseContract, ANewPathReplacesTheOneInProgress) {
  base_.Start({{Beside(1.2, 0.0, 0.0)}});
  Wait(1.0);
  const Pose2 goal = Beside(-0.3, 0.4, -1.0);
  base_.Start({{goal}});
  EXPECT_EQ(base_.Status().phase, MotionPhase::kMoving);
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
  ExpectAt(goal);
}

TEST_P(BaseContract, StopEndsAMotion) {
  base_.Start({{Beside(1.2, 0.0, 0.0)}});
  Wait(1.0);
  base_.Stop();
  const MotionStatus status = WaitForEnd();
  EXPECT_EQ(status.phase, MotionPhase::kStopped);
  EXPECT_EQ(status.reason, "");
  ExpectStandsStill();
}

TEST_P(BaseContract, StopWorksFromAnotherThread) {
  base_.Start({{Beside(1.2, 0.0, 0.0)}});
  std::thread stopper([&] { base_.Stop(); });
  stopper.join();
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kStopped);
  ExpectStandsStill();
}

TEST_P(BaseContract, StopIsPossibleWhenNothingMovesAndHindersNoLaterMotion) {
  base_.Stop();
  Wait(0.1);
  EXPECT_EQ(base_.Status().phase, MotionPhase::kIdle);
  const Pose2 goal = Beside(0.4, 0.0, 0.0);
  base_.Start({{goal}});
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
  base_.Stop();
  Wait(0.1);
  EXPECT_EQ(base_.Status().phase, MotionPhase::kReached);
}

TEST_P(BaseContract, TimesNeverDecreaseAndPosesAreSmooth) {
  base_.Start({{Beside(1.0, 0.3, 0.5)}});
  BaseState last = base_.State();
  while (base_.Status().phase == MotionPhase::kMoving) {
    Wait(0.05);
    const BaseState state = base_.State();
    EXPECT_GE(state.time, last.time);
    EXPECT_LE(state.time, clock_.Now());
    const double most = base_.info().speed * (ToSeconds(state.time - last.time) + 0.05) + 0.05;
    EXPECT_LE(std::hypot(state.X_OB.x - last.X_OB.x, state.X_OB.y - last.X_OB.y), most);
    EXPECT_LE(std::hypot(state.X_WB.x - last.X_WB.x, state.X_WB.y - last.X_WB.y), most);
    last = state;
  }
}

TEST_P(BaseContract, CovarianceIsSymmetricAndNotNegative) {
  const Eigen::Matrix3d covariance = base_.State().covariance_WB;
  EXPECT_TRUE(covariance.isApprox(covariance.transpose()) || covariance.isZero());
  EXPECT_GE(covariance.diagonal().minCoeff(), 0.0);
}

TEST_P(BaseContract, RefusesAnEmptyPathAndOneThatIsNotFinite) {
  EXPECT_THROWS(base_.Start({}), InvalidArgument, "no waypoint");
  Pose2 goal = Beside(0.4, 0.0, 0.0);
  goal.yaw = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROWS(base_.Start({{goal}}), InvalidArgument, "is not finite");
  goal = {std::numeric_limits<double>::infinity(), 0.0, 0.0};
  EXPECT_THROWS(base_.Start({{Beside(0.4, 0.0, 0.0), goal}}), InvalidArgument, "waypoint 1");
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(BaseContract);

}  // namespace secondlook::hal
