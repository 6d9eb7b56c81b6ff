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
#include "lib/hal/arm.h"
#include "tests/support/expect_throws.h"

namespace secondlook::hal {

/// An arm to be held to what lib/hal/arm.h promises, and the clock of its robot. Every joint must
/// be able to turn by 0.3 rad from where it is toward the middle of its range.
struct ArmRig {
  Clock* clock{};
  Arm* arm{};
  std::shared_ptr<void> owner;  ///< Keeps both alive; of a type that only the factory knows.
};

/// Makes the same kind of arm anew for each test.
struct ArmFactory {
  std::string name;  ///< Of the backend, in the names of the tests.
  std::function<ArmRig()> make;

  friend void PrintTo(const ArmFactory& factory, std::ostream* out) { *out << factory.name; }
};

class ArmContract : public ::testing::TestWithParam<ArmFactory> {
 protected:
  ArmContract() : rig_(GetParam().make()), clock_(*rig_.clock), arm_(*rig_.arm) {}

  void Wait(double seconds) { clock_.SleepUntil(clock_.Now() + Seconds(seconds)); }

  /// Waits for the end of the motion, a minute at most.
  MotionStatus WaitForEnd() {
    for (int i = 0; i < 3000 && arm_.Status().phase == MotionPhase::kMoving; ++i) Wait(0.02);
    return arm_.Status();
  }

  int Joints() const { return static_cast<int>(arm_.info().joints.size()); }

  /// Where the arm is, each joint turned by `turn` [rad] toward the middle of its range.
  Eigen::VectorXd Inward(double turn) {
    Eigen::VectorXd q = arm_.State().q;
    for (int i = 0; i < q.size(); ++i) {
      const JointInfo& joint = arm_.info().joints[i];
      q[i] += q[i] > 0.5 * (joint.lower + joint.upper) ? -turn : turn;
    }
    return q;
  }

  /// From rest where the arm is to rest at `goal`, in a time that keeps every limit twice over: one
  /// cubic over T is at most 1.5 way / T fast and accelerates by at most 6 way / T^2.
  JointTrajectory To(const Eigen::VectorXd& goal) {
    const Eigen::VectorXd q = arm_.State().q;
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(q.size());
    double seconds = 0.1;
    for (int i = 0; i < q.size(); ++i) {
      const JointInfo& joint = arm_.info().joints[i];
      const double way = std::abs(goal[i] - q[i]);
      seconds =
          std::max({seconds, 3.0 * way / joint.speed, std::sqrt(12.0 * way / joint.acceleration)});
    }
    return {{{0.0, q, rest}, {seconds, goal, rest}}};
  }

  void ExpectAt(const Eigen::VectorXd& goal) {
    EXPECT_LE((arm_.State().q - goal).cwiseAbs().maxCoeff(), 0.5 / 180.0 * M_PI);
  }

  void ExpectStandsStill() {
    const Eigen::VectorXd before = arm_.State().q;
    Wait(0.2);
    EXPECT_LE((arm_.State().q - before).cwiseAbs().maxCoeff(), 1e-3);
  }

  /// A trajectory `refused` for a reason that contains `text` leaves the arm as it was.
  void ExpectRefused(const JointTrajectory& refused, const std::string& text) {
    const MotionPhase phase = arm_.Status().phase;
    EXPECT_THROWS(arm_.Start(refused), InvalidArgument, text);
    EXPECT_THROWS(arm_.Start(refused), InvalidArgument, arm_.info().name);
    EXPECT_EQ(arm_.Status().phase, phase);
    ExpectStandsStill();
  }

  ArmRig rig_;
  Clock& clock_;
  Arm& arm_;
};

TEST_P(ArmContract, InfoIsValid) {
  EXPECT_FALSE(arm_.info().name.empty());
  EXPECT_GT(Joints(), 0);
  for (const JointInfo& joint : arm_.info().joints) {
    EXPECT_FALSE(joint.name.empty());
    EXPECT_LT(joint.lower, joint.upper) << joint.name;
    EXPECT_GT(joint.speed, 0.0) << joint.name;
    EXPECT_GT(joint.acceleration, 0.0) << joint.name;
  }
}

TEST_P(ArmContract, IsIdleWithinItsLimitsUntilSomethingIsStarted) {
  EXPECT_EQ(arm_.Status().phase, MotionPhase::kIdle);
  const Eigen::VectorXd q = arm_.State().q;
  ASSERT_EQ(q.size(), Joints());
  for (int i = 0; i < Joints(); ++i) {
    EXPECT_GE(q[i], arm_.info().joints[i].lower);
    EXPECT_LE(q[i], arm_.info().joints[i].upper);
  }
  ExpectStandsStill();
}

TEST_P(ArmContract, StartReturnsAtOnce) {
  const Time before = clock_.Now();
  arm_.Start(To(Inward(0.2)));
  EXPECT_LT(clock_.Now() - before, Seconds(0.02));
  EXPECT_EQ(arm_.Status().phase, MotionPhase::kMoving);
}

TEST_P(ArmContract, ReachesTheEndOfItsTrajectoryAndStandsStill) {
  const Eigen::VectorXd home = arm_.State().q;
  for (const Eigen::VectorXd& goal : {Inward(0.3), Inward(0.1), home}) {
    arm_.Start(To(goal));
    const MotionStatus status = WaitForEnd();
    EXPECT_EQ(status.phase, MotionPhase::kReached) << status.reason;
    EXPECT_EQ(status.reason, "");
    ExpectAt(goal);
    ExpectStandsStill();
  }
}

TEST_P(ArmContract, PassesItsKnotsAtTheirTimes) {
  const Eigen::VectorXd corner = Inward(0.3);
  JointTrajectory there = To(corner);
  const double half = there.seconds();
  there.knots.push_back({2.0 * half, there.knots.front().q, there.knots.front().v});
  const Time begun = clock_.Now();
  arm_.Start(there);
  clock_.SleepUntil(begun + Seconds(half));
  // It may lag by a tenth of a second; near its standstill that is nothing.
  EXPECT_LE((arm_.State().q - corner).cwiseAbs().maxCoeff(), 0.03);
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
  EXPECT_GE(clock_.Now() - begun, Seconds(2.0 * half - 0.1));
  ExpectAt(there.knots.front().q);
}

TEST_P(ArmContract, ATrajectoryOfOneKnotIsReachedWhereItIs) {
  const Eigen::VectorXd here = arm_.State().q;
  arm_.Start({{{0.0, here, Eigen::VectorXd::Zero(Joints())}}});
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
  ExpectAt(here);
}

TEST_P(ArmContract, AMotionInProgressIsNotReplaced) {
  const Eigen::VectorXd goal = Inward(0.3);
  arm_.Start(To(goal));
  Wait(0.2);
  EXPECT_THROWS(arm_.Start(To(Inward(0.1))), InvalidArgument, "moving");
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
  ExpectAt(goal);
}

TEST_P(ArmContract, StopEndsAMotionOnItsWay) {
  const Eigen::VectorXd home = arm_.State().q;
  const Eigen::VectorXd goal = Inward(0.3);
  arm_.Start(To(goal));
  Wait(0.2);
  arm_.Stop();
  const MotionStatus status = WaitForEnd();
  EXPECT_EQ(status.phase, MotionPhase::kStopped);
  EXPECT_EQ(status.reason, "");
  ExpectStandsStill();
  const Eigen::VectorXd q = arm_.State().q;
  for (int i = 0; i < q.size(); ++i) {
    EXPECT_GE(q[i], std::min(home[i], goal[i]) - 0.01);
    EXPECT_LE(q[i], std::max(home[i], goal[i]) + 0.01);
  }
}

TEST_P(ArmContract, StopWorksFromAnotherThread) {
  arm_.Start(To(Inward(0.3)));
  std::thread stopper([&] { arm_.Stop(); });
  stopper.join();
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kStopped);
  ExpectStandsStill();
}

TEST_P(ArmContract, StopIsPossibleWhenNothingMovesAndHindersNoLaterMotion) {
  arm_.Stop();
  Wait(0.1);
  EXPECT_EQ(arm_.Status().phase, MotionPhase::kIdle);
  const Eigen::VectorXd goal = Inward(0.2);
  arm_.Start(To(goal));
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
  arm_.Stop();
  Wait(0.1);
  EXPECT_EQ(arm_.Status().phase, MotionPhase::kReached);
}

TEST_P(ArmContract, MovesOnFromWhereItWasStopped) {
  const Eigen::VectorXd goal = Inward(0.3);
  arm_.Start(To(goal));
  Wait(0.2);
  arm_.Stop();
  WaitForEnd();
  arm_.Start(To(goal));
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
  ExpectAt(goal);
}

TEST_P(ArmContract, TimesNeverDecreaseAndPositionsAreSmooth) {
  arm_.Start(To(Inward(0.3)));
  ArmState last = arm_.State();
  while (arm_.Status().phase == MotionPhase::kMoving) {
    Wait(0.02);
    const ArmState state = arm_.State();
    EXPECT_GE(state.time, last.time);
    EXPECT_LE(state.time, clock_.Now());
    for (int i = 0; i < Joints(); ++i) {
      const double most =
          arm_.info().joints[i].speed * (ToSeconds(state.time - last.time) + 0.02) + 0.01;
      EXPECT_LE(std::abs(state.q[i] - last.q[i]), most);
    }
    last = state;
  }
}

TEST_P(ArmContract, RefusesATrajectoryThatIsNone) {
  ExpectRefused({}, "no knot");
  JointTrajectory wrong = To(Inward(0.2));
  wrong.knots[1].q.conservativeResize(Joints() + 1);
  ExpectRefused(wrong, fmt::format("{} positions", Joints() + 1));
  wrong = To(Inward(0.2));
  wrong.knots[1].q[0] = std::numeric_limits<double>::quiet_NaN();
  ExpectRefused(wrong, "knot 1 of the trajectory is not finite");
  wrong = To(Inward(0.2));
  wrong.knots[1].seconds = 0.0;
  ExpectRefused(wrong, "is not later");
}

TEST_P(ArmContract, RefusesATrajectoryThatDoesNotBeginWhereItIsAtRest) {
  JointTrajectory wrong = To(Inward(0.2));
  wrong.knots[0].q = Inward(0.1);
  ExpectRefused(wrong, "plan from where the arm is");
  wrong = To(Inward(0.2));
  wrong.knots[0].v[0] = 0.01;
  ExpectRefused(wrong, "it must be at rest");
}

TEST_P(ArmContract, RefusesWhatBreaksALimitAndNamesTheJoint) {
  const JointInfo& joint = arm_.info().joints[0];
  Eigen::VectorXd beyond = arm_.State().q;
  beyond[0] = joint.upper + 0.01;
  ExpectRefused(To(beyond), joint.name);
  ExpectRefused(To(beyond), fmt::format("{:.2f} deg", joint.upper / M_PI * 180.0));

  JointTrajectory fast = To(Inward(0.3));
  // So fast that the speed is too high, over so short a way that nothing else needs to be.
  fast.knots[1].seconds = 0.9 * 1.5 * 0.3 / joint.speed;
  ExpectRefused(fast, "its limit is");
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ArmContract);

}  // namespace secondlook::hal
