#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "lib/common/clock.h"
#include "lib/common/error.h"
#include "lib/hal/laser_striper.h"
#include "tests/support/expect_throws.h"

namespace secondlook::hal {

/// A striper to be held to what lib/hal/laser_striper.h promises, and the clock of its robot. There
/// must be something within its range.
struct StriperRig {
  Clock* clock{};
  LaserStriper* striper{};
  std::function<bool()> lit;    ///< True when the laser truly is on.
  int held{};                   ///< So many lines wait at most to be taken: under 15.
  std::function<void()> lose;   ///< Breaks the connection for good.
  std::shared_ptr<void> owner;  ///< Keeps all alive; of a type that only the factory knows.
};

/// Makes the same kind of striper anew for each test.
struct StriperFactory {
  std::string name;  ///< Of the backend, in the names of the tests.
  std::function<StriperRig()> make;

  friend void PrintTo(const StriperFactory& factory, std::ostream* out) { *out << factory.name; }
};

class LaserStriperContract : public ::testing::TestWithParam<StriperFactory> {
 protected:
  LaserStriperContract() : rig_(GetParam().make()), clock_(*rig_.clock), striper_(*rig_.striper) {}

  void Wait(double seconds) { clock_.SleepUntil(clock_.Now() + Seconds(seconds)); }

  /// Takes lines for as long as `seconds`, so often that none is lost.
  std::vector<ScanLine> TakeFor(double seconds) {
    std::vector<ScanLine> lines;
    const Time end = clock_.Now() + Seconds(seconds);
    while (clock_.Now() < end) {
      Wait(0.02);
      for (ScanLine& line : striper_.Take()) lines.push_back(std::move(line));
    }
    return lines;
  }

  /// True once `said` holds, within a second.
  bool Soon(const std::function<bool()>& said) {
    for (int i = 0; i < 50 && !said(); ++i) Wait(0.02);
    return said();
  }

  StriperRig rig_;
  Clock& clock_;
  LaserStriper& striper_;
};

TEST_P(LaserStriperContract, InfoIsValid) {
  const StriperInfo& info = striper_.info();
  EXPECT_FALSE(info.name.empty());
  EXPECT_GE(info.points, 2);
  EXPECT_GT(info.field_of_view, 0.0);
  EXPECT_LT(info.field_of_view, M_PI);
  EXPECT_GT(info.min_range, 0.0);
  EXPECT_LT(info.min_range, info.max_range);
  EXPECT_GT(info.lines_per_second, 0.0);
  EXPECT_GT(info.range_sigma, 0.0);
}

TEST_P(LaserStriperContract, IsOffUntilItIsSwitchedOn) {
  EXPECT_FALSE(rig_.lit());
  EXPECT_TRUE(TakeFor(0.2).empty());
  EXPECT_EQ(striper_.lost(), 0U);
}

TEST_P(LaserStriperContract, SendsItsLinesWhileItIsOn) {
  striper_.On();
  EXPECT_TRUE(Soon(rig_.lit));
  const std::vector<ScanLine> lines = TakeFor(0.6);
  EXPECT_GE(lines.size(), 0.3 * striper_.info().lines_per_second);
  EXPECT_LE(lines.size(), 0.6 * striper_.info().lines_per_second + 3);
  striper_.Off();
  EXPECT_TRUE(Soon([&] { return !rig_.lit(); }));
  TakeFor(0.1);  // what was still under way
  EXPECT_TRUE(TakeFor(0.2).empty());
}

TEST_P(LaserStriperContract, RangesAreNanOrWithinTheRange) {
  striper_.On();
  int measured = 0;
  for (const ScanLine& line : TakeFor(0.3)) {
    ASSERT_EQ(line.ranges.size(), static_cast<std::size_t>(striper_.info().points));
    for (const float range : line.ranges) {
      if (std::isnan(range)) continue;
      ++measured;
      ASSERT_GE(range, striper_.info().min_range);
      ASSERT_LE(range, striper_.info().max_range);
    }
  }
  EXPECT_GT(measured, 0);
}

TEST_P(LaserStriperContract, TimesStrictlyIncreaseFromOnToNow) {
  Wait(0.1);
  Time last = clock_.Now() - Duration(1);
  striper_.On();
  for (const ScanLine& line : TakeFor(0.4)) {
    EXPECT_GT(line.time, last);
    EXPECT_LE(line.time, clock_.Now());
    last = line.time;
  }
}

TEST_P(LaserStriperContract, NoLineIsMissingWhenTheyAreTakenInTime) {
  striper_.On();
  const std::vector<ScanLine> lines = TakeFor(0.5);
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.back().sequence - lines.front().sequence + 1, lines.size());
  EXPECT_EQ(striper_.lost(), 0U);
}

TEST_P(LaserStriperContract, CountsTheLinesThatNobodyTook) {
  striper_.On();
  std::vector<ScanLine> lines = TakeFor(0.1);
  ASSERT_FALSE(lines.empty());
  Wait(0.45);
  for (ScanLine& line : striper_.Take()) lines.push_back(std::move(line));
  EXPECT_GT(striper_.lost(), 0U);
  EXPECT_EQ(lines.back().sequence - lines.front().sequence + 1, lines.size() + striper_.lost());
}

TEST_P(LaserStriperContract, GoesOffWhenNobodyAttendsToIt) {
  striper_.On();
  EXPECT_TRUE(Soon(rig_.lit));
  Wait(ToSeconds(LaserStriper::kAttended) + 0.2);
  EXPECT_FALSE(rig_.lit());
}

TEST_P(LaserStriperContract, StaysOnWhileItsLinesAreTaken) {
  striper_.On();
  TakeFor(2.0 * ToSeconds(LaserStriper::kAttended) + 0.1);
  EXPECT_TRUE(rig_.lit());
}

TEST_P(LaserStriperContract, GoesOffFromAnotherThreadAndOnAgain) {
  striper_.Off();  // it is
  striper_.On();
  TakeFor(0.1);
  std::thread stopper([&] { striper_.Off(); });
  stopper.join();
  EXPECT_TRUE(Soon([&] { return !rig_.lit(); }));
  TakeFor(0.1);
  striper_.On();
  EXPECT_FALSE(TakeFor(0.3).empty());
}

TEST_P(LaserStriperContract, OnceLostItSaysSoAndNamesItself) {
  striper_.On();
  TakeFor(0.1);
  rig_.lose();
  const auto use = [&] {
    for (int i = 0; i < 200; ++i) {
      Wait(0.02);
      striper_.Take();
    }
  };
  EXPECT_THROWS(use(), DeviceError, striper_.info().name);
  striper_.Off();
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LaserStriperContract);

}  // namespace secondlook::hal
