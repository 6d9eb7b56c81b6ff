#include "lib/transport/lcm_bus.h"

#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/transport/channels.h"
#include "tests/support/expect_throws.h"

#include "second_look/command_t.hpp"
#include "second_look/task_t.hpp"

namespace secondlook::transport {
namespace {

second_look::command_t MakeStop() {
  second_look::command_t stop{};
  stop.utime = 1'234'567;
  stop.command = second_look::command_t::STOP;
  stop.reason = "enough";
  return stop;
}

/// A bus in memory that keeps what comes in on SECONDLOOK_COMMAND.
struct ListeningBus {
  LcmBus bus{"memq://"};
  std::vector<Message> heard;

  ListeningBus() {
    bus.Listen(channel::kCommand, [this](const Message& message) { heard.push_back(message); });
  }

  void Bring(std::vector<std::uint8_t> bytes) {
    bus.Publish({channel::kCommand, 0, std::move(bytes)});
    bus.Handle();
  }
};

TEST(LcmBus, HandsOnWhatComesInAsItWasSent) {
  ListeningBus in;
  const Message sent = Pack(channel::kCommand, MakeStop());
  in.Bring(sent.bytes);
  ASSERT_EQ(in.heard.size(), 1U);
  EXPECT_EQ(in.heard[0].channel, "SECONDLOOK_COMMAND");
  EXPECT_EQ(in.heard[0].utime, 1'234'567);
  EXPECT_EQ(in.heard[0].bytes, sent.bytes);
  EXPECT_EQ(in.bus.counts().sent, 1);
  EXPECT_EQ(in.bus.counts().received, 1);
  EXPECT_EQ(in.bus.counts().rejected, 0);
}

TEST(LcmBus, KnowsWhichUrlsReachBeyondThisHost) {
  EXPECT_FALSE(ReachesBeyondThisHost(kDefaultLcmUrl));
  EXPECT_FALSE(ReachesBeyondThisHost("udpm://239.255.76.67:7667"));
  EXPECT_FALSE(ReachesBeyondThisHost("memq://"));
  EXPECT_FALSE(ReachesBeyondThisHost("udpm://239.255.76.67:7667?ttl=00&recv_buf_size=1"));
  EXPECT_TRUE(ReachesBeyondThisHost("udpm://239.255.76.67:7667?ttl=1"));
  EXPECT_TRUE(ReachesBeyondThisHost("udpm://239.255.76.67:7667?recv_buf_size=1&ttl=10"));
}

TEST(LcmBus, HoldsAnyChannelToTheLimitsThatWereSetForIt) {
  LcmBus bus("memq://");
  int heard = 0;
  std::string rejected;
  Intake intake{"second_look.command_t", {}};
  intake.limits.characters = 3;
  intake.on_reject = [&](const std::string& why) { rejected = why; };
  bus.Listen("ANY", intake, [&](const Message&) { ++heard; });
  bus.Publish(Pack("ANY", MakeStop()));
  bus.Handle();
  EXPECT_EQ(heard, 0);
  EXPECT_NE(rejected.find("'reason' has 6 characters, at most 3 are taken"), std::string::npos);
  EXPECT_EQ(bus.counts().rejected, 1);
  EXPECT_THROWS(bus.Listen("ANY", {"second_look.none_t", {}}, {}), InvalidArgument, "none_t");
}

TEST(LcmBus, HandsNothingOnBeforeItIsAskedTo) {
  ListeningBus in;
  in.bus.Publish(Pack(channel::kCommand, MakeStop()));
  EXPECT_TRUE(in.heard.empty());
}

TEST(LcmBus, RejectsGarbageAndSaysOnWhichChannelAndWhy) {
  ListeningBus in;
  const std::vector<std::uint8_t> good = Encode(MakeStop());
  const auto rejects = [&](std::vector<std::uint8_t> bytes, const std::string& why) {
    const std::int64_t before = in.bus.counts().rejected;
    in.Bring(std::move(bytes));
    EXPECT_EQ(in.bus.counts().rejected, before + 1) << why;
    EXPECT_THAT(in.bus.counts().last_rejected, ::testing::StartsWith("SECONDLOOK_COMMAND: "));
    EXPECT_THAT(in.bus.counts().last_rejected, ::testing::HasSubstr(why));
  };
  rejects({}, "cut off in 'fingerprint'");
  rejects({1, 2, 3}, "cut off in 'fingerprint'");
  rejects({good.begin(), good.end() - 1}, "cut off in 'reason'");
  rejects(Encode(second_look::task_t{}), "another type or version");
  std::vector<std::uint8_t> longer = good;
  longer.resize(longer.size() + 5);
  rejects(longer, "5 bytes left over");
  longer.resize(1'000'000);
  rejects(longer, "1000000 bytes long, at most 100000 are taken");
  EXPECT_TRUE(in.heard.empty());
}

TEST(LcmBus, RejectsOrHandsOnWhateverIsBroughtToIt) {
  ListeningBus in;
  Rng rng(11);
  const std::vector<std::uint8_t> good = Encode(MakeStop());
  for (int i = 0; i < 5'000; ++i) {
    std::vector<std::uint8_t> bytes = good;
    bytes[rng.Bits() % bytes.size()] = static_cast<std::uint8_t>(rng.Bits());
    bytes.resize(rng.Bits() % 4 == 0 ? rng.Bits() % 40 : bytes.size());
    in.Bring(std::move(bytes));
  }
  EXPECT_EQ(in.bus.counts().received, 5'000);
  EXPECT_GT(in.bus.counts().rejected, 1'000);
  EXPECT_EQ(in.bus.counts().rejected + std::ssize(in.heard), 5'000);
}

TEST(LcmBus, CountsAsRejectedWhatItsHandlerRefuses) {
  LcmBus bus("memq://");
  bus.Listen(channel::kCommand,
             [](const Message&) { Throw<ProtocolError>("there is no command 7"); });
  bus.Publish(Pack(channel::kCommand, MakeStop()));
  bus.Handle();
  EXPECT_EQ(bus.counts().rejected, 1);
  EXPECT_EQ(bus.counts().last_rejected, "SECONDLOOK_COMMAND: there is no command 7");
}

TEST(LcmBus, LeavesTheRestOfAFloodForTheNextTime) {
  ListeningBus in;
  for (int i = 0; i < LcmBus::kQueue + 500; ++i) {
    in.bus.Publish(Pack(channel::kCommand, MakeStop()));
  }
  in.bus.Handle();
  EXPECT_EQ(std::ssize(in.heard), LcmBus::kQueue);
  in.bus.Handle();
  EXPECT_EQ(std::ssize(in.heard), LcmBus::kQueue + 500);
}

TEST(LcmBus, RefusesAUrlThatWouldMakeItWaitOrThatLcmDoesNotTake) {
  EXPECT_THROWS(LcmBus("tcpq://localhost:7700"), ConfigError,
                "LCM URL 'tcpq://localhost:7700': it must begin with udpm:// or memq://");
  EXPECT_THROWS(LcmBus(""), ConfigError, "e.g. udpm://239.255.76.67:7667?ttl=0");
  EXPECT_THROWS(LcmBus("udpm://nowhere:7667"), ConfigError, "LCM does not take it");
}

TEST(LcmBus, ListensToChannelsOfOursAlone) {
  LcmBus bus("memq://");
  EXPECT_THROWS(bus.Listen("POSE_BODY", [](const Message&) {}), InvalidArgument,
                "'POSE_BODY' is no channel of ours");
}

}  // namespace
}  // namespace secondlook::transport
