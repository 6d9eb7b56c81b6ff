#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "lib/common/clock.h"

namespace secondlook {

/// A clock to be held to what lib/common/clock.h promises.
struct ClockRig {
  Clock* clock{};
  std::shared_ptr<void> owner;  ///< Keeps the clock alive; of a type that only the factory knows.
};

/// Makes the same kind of clock anew for each test.
struct ClockFactory {
  std::string name;  ///< Of the backend, in the names of the tests.
  std::function<ClockRig()> make;

  friend void PrintTo(const ClockFactory& factory, std::ostream* out) { *out << factory.name; }
};

class ClockContract : public ::testing::TestWithParam<ClockFactory> {
 protected:
  ClockContract() : rig_(GetParam().make()), clock_(*rig_.clock) {}
  ClockRig rig_;
  Clock& clock_;
};

TEST_P(ClockContract, SleepUntilReturnsWhenTheTimeHasCome) {
  const Time time = clock_.Now() + Seconds(0.25);
  clock_.SleepUntil(time);
  EXPECT_GE(clock_.Now(), time);
}

TEST_P(ClockContract, SleepUntilWhatHasPassedReturnsAtOnce) {
  clock_.SleepUntil(clock_.Now() + Seconds(0.1));
  const Time now = clock_.Now();
  clock_.SleepUntil(now - Seconds(0.05));
  EXPECT_LT(clock_.Now() - now, Seconds(0.05));
}

TEST_P(ClockContract, NeverRunsBackwards) {
  Time last = clock_.Now();
  for (int i = 0; i < 20; ++i) {
    if (i % 2 == 0) clock_.SleepUntil(last + Seconds(0.003));
    if (i % 3 == 0) clock_.ChargeThinking(Seconds(0.004));
    EXPECT_GE(clock_.Now(), last);
    last = clock_.Now();
  }
}

TEST_P(ClockContract, ChargingNothingIsAllowed) {
  const Time now = clock_.Now();
  clock_.ChargeThinking(Duration::zero());
  EXPECT_GE(clock_.Now(), now);
}

TEST_P(ClockContract, NowMayBeAskedFromAnotherThreadWhileOneSleeps) {
  std::atomic<bool> done{false};
  bool monotone = true;
  std::thread watcher([&] {
    Time last = clock_.Now();
    while (!done) {
      const Time now = clock_.Now();
      monotone = monotone && now >= last;
      last = now;
    }
  });
  clock_.SleepUntil(clock_.Now() + Seconds(0.2));
  done = true;
  watcher.join();
  EXPECT_TRUE(monotone);
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ClockContract);

}  // namespace secondlook
