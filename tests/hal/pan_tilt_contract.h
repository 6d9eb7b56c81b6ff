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
#include "lib/hal/pan_tilt.h"
#include "tests/support/expect_throws.h"

namespace secondlook::hal {

/// A pan-tilt head to be held to what lib/hal/pan_tilt.h promises, and the clock of its robot.
struct PanTiltRig {
  Clock* clock{};
  PanTilt* head{};
  std::shared_ptr<void> owner;  ///< Keeps both alive; of a type that only the factory knows.
};

/// Makes the same kind of head anew for each test.
struct PanTiltFactory {
  std::string name;  ///< Of the backend, in the names of the tests.
  std::function<PanTiltRig()> make;

  friend void PrintTo(const PanTiltFactory& factory, std::ostream* out) { *out << factory.name; }
};

class PanTiltContract : public ::testing::TestWithParam<PanTiltFactory> {
 protected:
  PanTiltContract() : rig_(GetParam().make()), clock_(*rig_.clock), head_(*rig_.head) {}

  void Wait(double seconds) { clock_.SleepUntil(clock_.Now() + Seconds(seconds)); }

  /// Waits for the end of the motion, a minute at most.
  MotionStatus WaitForEnd() {
    for (int i = 0; i < 3000 && head_.Status().phase == MotionPhase::kMoving; ++i) Wait(0.02);
    return head_.Status();
  }

  void ExpectAt(const PanTiltAngles& target) {
    const PanTiltAngles angles = head_.State().angles;
    EXPECT_LE(std::abs(angles.pan - target.pan), 0.5 / 180.0 * M_PI);
    EXPECT_LE(std::abs(angles.tilt - target.tilt), 0.5 / 180.0 * M_PI);
  }

  void ExpectStandsStill() {
    const PanTiltAngles before = head_.State().angles;
    Wait(0.2);
    const PanTiltAngles after = head_.State().angles;
    EXPECT_NEAR(before.pan, after.pan, 1e-3);
    EXPECT_NEAR(before.tilt, after.tilt, 1e-3);
  }

  /// The angles at `pan` and `tilt` in [0, 1] between the limits.
  PanTiltAngles Within(double pan, double tilt) const {
    const PanTiltInfo& info = head_.info();
    return {info.lower.pan + pan * (info.upper.pan - info.lower.pan),
            info.lower.tilt + tilt * (info.upper.tilt - info.lower.tilt)};
  }

  PanTiltRig rig_;
  Clock& clock_;
  PanTilt& head_;
};

TEST_P(PanTiltContract, InfoIsValid) {
  EXPECT_FALSE(head_.info().name.empty());
  EXPECT_LE(head_.info().lower.pan, head_.info().upper.pan);
  EXPECT_LE(head_.info().lower.tilt, head_.info().upper.tilt);
  EXPECT_GT(head_.info().speed, 0.0);
}

TEST_P(PanTiltContract, IsIdleUntilSomethingIsStarted) {
  EXPECT_EQ(head_.Status().phase, MotionPhase::kIdle);
  ExpectStandsStill();
}

TEST_P(PanTiltContract, StartReturnsAtOnce) {
  const Time before = clock_.Now();
  head_.Start(Within(0.8, 0.8));
  EXPECT_LT(clock_.Now() - before, Seconds(0.02));
  EXPECT_EQ(head_.Status().phase, MotionPhase::kMoving);
}

TEST_P(PanTiltContract, ReachesItsTargetAndStandsStill) {
  for (const PanTiltAngles& target : {Within(0.9, 0.2), Within(0.0, 0.0), Within(1.0, 1.0)}) {
    head_.Start(target);
    const MotionStatus status = WaitForEnd();
    EXPECT_EQ(status.phase, MotionPhase::kReached) << status.reason;
    EXPECT_EQ(status.reason, "");
    ExpectAt(target);
    ExpectStandsStill();
  }
}

TEST_P(PanTiltContract, AMotionToWhereItIsIsReached) {
  const PanTiltAngles here = head_.State().angles;
  head_.Start(here);
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
  ExpectAt(here);
}

TEST_P(PanTiltContract, ANewMotionReplacesTheOneInProgress) {
  head_.Start(Within(1.0, 1.0));
  for (int i = 0; i < 30; ++i) {  // at many phases of the ramp
    Wait(0.03);
    head_.Start(i % 2 == 0 ? Within(0.2, 0.5) : Within(0.8, 0.4));
    EXPECT_EQ(head_.Status().phase, MotionPhase::kMoving);
  }
  const PanTiltAngles target = Within(0.3, 0.6);
  head_.Start(target);
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
  ExpectAt(target);
}

TEST_P(PanTiltContract, StopEndsAMotion) {
  head_.Start(Within(1.0, 1.0));
  Wait(0.1);
  head_.Stop();
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kStopped);
  ExpectStandsStill();
}

TEST_P(PanTiltContract, StopWorksFromAnotherThread) {
  head_.Start(Within(1.0, 1.0));
  std::thread stopper([&] { head_.Stop(); });
  stopper.join();
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kStopped);
}

TEST_P(PanTiltContract, StopIsPossibleWhenNothingMovesAndHindersNoLaterMotion) {
  head_.Stop();
  Wait(0.1);
  EXPECT_EQ(head_.Status().phase, MotionPhase::kIdle);
  head_.Start(Within(0.4, 0.4));
  EXPECT_EQ(WaitForEnd().phase, MotionPhase::kReached);
}

TEST_P(PanTiltContract, TimesNeverDecreaseAndAnglesAreSmooth) {
  head_.Start(Within(1.0, 0.0));
  PanTiltState last = head_.State();
  while (head_.Status().phase == MotionPhase::kMoving) {
    Wait(0.02);
    const PanTiltState state = head_.State();
    EXPECT_GE(state.time, last.time);
    EXPECT_LE(state.time, clock_.Now());
    const double most = head_.info().speed * (ToSeconds(state.time - last.time) + 0.02) + 0.01;
    EXPECT_LE(std::abs(state.angles.pan - last.angles.pan), most);
    EXPECT_LE(std::abs(state.angles.tilt - last.angles.tilt), most);
    last = state;
  }
}

TEST_P(PanTiltContract, RefusesWhatLiesOutsideItsLimitsAndNamesThem) {
  const PanTiltInfo& info = head_.info();
  const std::string limit = fmt::format("{:.2f}", info.upper.pan / M_PI * 180.0);
  EXPECT_THROWS(head_.Start({info.upper.pan + 0.01, 0.0}), InvalidArgument, limit);
  EXPECT_THROWS(head_.Start({0.0, info.lower.tilt - 0.01}), InvalidArgument, "limits");
  EXPECT_THROWS(head_.Start({std::numeric_limits<double>::quiet_NaN(), 0.0}), InvalidArgument,
                "limits");
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(PanTiltContract);

}  // namespace secondlook::hal
