// Lines that come over LCM, from a striper that is emulated on the same link.

#include "lib/hal/drivers/lcm_striper.h"

#include <cmath>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/hal/laser_striper_contract.h"
#include "tests/lcm_drivers/striper_emulator.h"
#include "tests/support/expect_throws.h"

namespace secondlook::hal {
namespace {

using second_look::striper_line_t;
using ::testing::HasSubstr;

LcmStriperConfig Config() {
  LcmStriperConfig config;
  config.points = 16;
  config.held = 12;
  config.patience_seconds = 0.5;
  return config;
}

/// A striper, its emulated device, and the network between them.
struct Connected {
  LiveClock clock;
  std::shared_ptr<LcmLink> link = std::make_shared<LcmLink>("memq://");
  StriperEmulator emulator{link.get(), 16};
  std::unique_ptr<LcmStriper> striper;

  explicit Connected(const LcmStriperConfig& config = Config())
      : striper(std::make_unique<LcmStriper>(config, link, &clock)) {}

  /// Lines until `seconds` have passed.
  std::vector<ScanLine> TakeFor(double seconds) const {
    std::vector<ScanLine> lines;
    const Time end = clock.Now() + Seconds(seconds);
    while (clock.Now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      for (ScanLine& line : striper->Take()) lines.push_back(std::move(line));
    }
    return lines;
  }

  /// What the striper says once it is lost because each line was spoilt in this way.
  std::string LostBy(std::function<void(striper_line_t*)> spoil) {
    emulator.Spoil(std::move(spoil));
    striper->On();
    try {
      TakeFor(20.0);
    } catch (const DeviceError& error) {
      striper->Off();
      return error.what();
    }
    return "";
  }
};

StriperFactory Factory(const std::string& name, bool synchronised) {
  return {name, [synchronised] {
            LcmStriperConfig config = Config();
            config.synchronised = synchronised;
            const auto c = std::make_shared<Connected>(config);
            return StriperRig{&c->clock,
                              c->striper.get(),
                              [e = &c->emulator] { return e->lit(); },
                              config.held,
                              [e = &c->emulator] { e->SetSilent(true); },
                              c};
          }};
}

const auto kName = [](const auto& info) { return info.param.name; };

INSTANTIATE_TEST_SUITE_P(Lcm, LaserStriperContract,
                         ::testing::Values(Factory("Synchronised", true),
                                           Factory("WithAClockOfItsOwn", false)),
                         kName);

TEST(LcmStriper, GivesMetresAndNanForNoReturn) {
  const Connected connected;
  connected.striper->On();
  const std::vector<ScanLine> lines = connected.TakeFor(0.2);
  ASSERT_FALSE(lines.empty());
  EXPECT_TRUE(std::isnan(lines[0].ranges[0]));
  EXPECT_TRUE(std::isnan(lines[0].ranges[1]));  // too near
  EXPECT_FLOAT_EQ(lines[0].ranges[2], 0.4F);
}

TEST(LcmStriper, CountsLinesThatWereLostOnTheirWay) {
  Connected connected;
  connected.striper->On();
  std::vector<ScanLine> lines = connected.TakeFor(0.1);
  connected.emulator.Lose(3);
  for (ScanLine& line : connected.TakeFor(0.3)) lines.push_back(std::move(line));
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(connected.striper->lost(), 3U);
  EXPECT_EQ(lines.back().sequence - lines.front().sequence + 1, lines.size() + 3);
}

TEST(LcmStriper, IsNotThereWhenNothingComes) {
  const LiveClock clock;
  const auto link = std::make_shared<LcmLink>("memq://");
  EXPECT_THROWS(LcmStriper(Config(), link, &clock), DeviceError,
                "striper 'striper': nothing came on channel 'STRIPER_STATUS' of memq:// for 0.5 s");
}

TEST(LcmStriper, SaysWhyItCannotMeasure) {
  Connected connected;
  connected.emulator.SetFault("the interlock is open");
  EXPECT_THROWS(connected.TakeFor(5.0), DeviceError,
                "striper 'striper': it cannot measure: the interlock is open");
}

TEST(LcmStriper, SaysWhatIsWrongWithItsLines) {
  Connected connected;
  EXPECT_THAT(connected.LostBy([](striper_line_t* line) {
    line->ranges.pop_back();
    line->num_ranges = 15;
  }),
              HasSubstr("a line has 15 ranges, and 'points' says 16: make the two equal"));
  EXPECT_THAT(connected.LostBy([](striper_line_t* line) {
    line->ranges.assign(40, 0.4F);
    line->num_ranges = 40;
  }),
              HasSubstr("no good line came on channel 'STRIPER_LINE' of memq:// for 0.5 s: "));
  EXPECT_THAT(connected.LostBy([](striper_line_t* line) { line->ranges[3] = NAN; }),
              HasSubstr("not finite"));
  EXPECT_THAT(connected.LostBy([](striper_line_t* line) { line->utime += 9'000'000; }),
              HasSubstr("ahead of this machine's clock"));
}

TEST(LcmStriper, RefusesAConfigurationThatIsNone) {
  LcmStriperConfig config = Config();
  config.points = 1;
  EXPECT_THROWS(config.Validate(), ConfigError, "'points' = 1 must lie in 2..10000");
  config = Config();
  config.max_range = 0.2;
  EXPECT_THROWS(config.Validate(), ConfigError, "'max_range' = 0.2 must lie in 0.3..65");
}

}  // namespace
}  // namespace secondlook::hal
