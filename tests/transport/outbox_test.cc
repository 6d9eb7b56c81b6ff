#include "lib/transport/outbox.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/transport/channels.h"

namespace secondlook::transport {
namespace {

using ::testing::ElementsAre;

/// A message of 100 bytes.
Message Hundred(const char* channel, std::int64_t utime) {
  return {channel, utime, std::vector<std::uint8_t>(100)};
}

/// The utimes of all that wait, in order.
std::vector<std::int64_t> TakeAll(Outbox* outbox) {
  std::vector<std::int64_t> utimes;
  while (const auto message = outbox->Take()) utimes.push_back(message->utime);
  return utimes;
}

TEST(Outbox, GivesOutWhatCameInTheOrderItCame) {
  Outbox outbox(1'000);
  EXPECT_TRUE(outbox.Empty());
  outbox.Post(Hundred(channel::kView, 1));
  outbox.Post(Hundred(channel::kImage, 2));
  outbox.Post(Hundred(channel::kLook, 3));
  EXPECT_FALSE(outbox.Empty());
  EXPECT_THAT(TakeAll(&outbox), ElementsAre(1, 2, 3));
  EXPECT_TRUE(outbox.Empty());
  EXPECT_EQ(outbox.drops(), 0);
}

TEST(Outbox, DropsTheOldestImageFirstAndDecisionsLast) {
  Outbox outbox(500);
  outbox.Post(Hundred(channel::kObjects, 1));
  outbox.Post(Hundred(channel::kImage, 2));
  outbox.Post(Hundred(channel::kNavStatus, 3));
  outbox.Post(Hundred(channel::kImage, 4));
  outbox.Post(Hundred(channel::kCandidates, 5));
  outbox.Post(Hundred(channel::kLook, 6));
  EXPECT_EQ(outbox.drops(), 1);
  outbox.Post(Hundred(channel::kLook, 7));
  outbox.Post(Hundred(channel::kLook, 8));
  EXPECT_EQ(outbox.drops(), 3);
  EXPECT_THAT(TakeAll(&outbox), ElementsAre(1, 5, 6, 7, 8));
}

TEST(Outbox, DropsTheOldestDecisionWhenNothingElseIsLeft) {
  Outbox outbox(300);
  for (int i = 1; i <= 4; ++i) outbox.Post(Hundred(channel::kLook, i));
  EXPECT_THAT(TakeAll(&outbox), ElementsAre(2, 3, 4));
  EXPECT_EQ(outbox.drops(), 1);
}

TEST(Outbox, DropsANewImageRatherThanAnOlderDecision) {
  Outbox outbox(200);
  outbox.Post(Hundred(channel::kLook, 1));
  outbox.Post(Hundred(channel::kObjects, 2));
  outbox.Post(Hundred(channel::kImage, 3));
  EXPECT_THAT(TakeAll(&outbox), ElementsAre(1, 2));
}

TEST(Outbox, HasRoomAgainForWhatWasTaken) {
  Outbox outbox(200);
  for (int i = 1; i <= 10; ++i) {
    outbox.Post(Hundred(channel::kImage, i));
    EXPECT_THAT(TakeAll(&outbox), ElementsAre(i));
  }
  EXPECT_EQ(outbox.drops(), 0);
}

}  // namespace
}  // namespace secondlook::transport
