#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lib/transport/channels.h"
#include "lib/transport/message_json.h"
#include "tests/mission/simulated_mission.h"

namespace secondlook::apps {
namespace {

class KeepAll : public transport::Sink {
 public:
  void Post(const transport::Message& message) override { messages.push_back(message); }
  std::vector<transport::Message> messages;
};

/// The default mission, run once for all tests, and what it told.
const KeepAll& Told() {
  static KeepAll sink;
  static const SimulatedMission run({}, {&sink});
  return sink;
}

nlohmann::ordered_json Body(const transport::Message& message) {
  return transport::ToJson(message.bytes, transport::TypeOn(message.channel));
}

TEST(MissionMessages, FollowTheSchemaAndFitIntoADefaultSocketBuffer) {
  std::map<std::string, int> count;
  for (const transport::Message& message : Told().messages) {
    EXPECT_NO_THROW(Body(message)) << message.channel;
    EXPECT_LE(message.bytes.size(), transport::kMaxMessageBytes) << message.channel;
    ++count[message.channel];
  }
  using namespace transport::channel;
  for (const char* channel : {kImage, kView, kPlane, kObjects, kOccupancy, kCandidates, kLook,
                              kNavGoal, kNavStatus, kTiming}) {
    EXPECT_GT(count[channel], 0) << channel;
  }
}

TEST(MissionMessages, OfAllPiecesArriveAndTheirStepsCountUp) {
  std::map<std::string, int> expected;  // piece, by channel
  std::map<std::string, int> step;
  for (const transport::Message& message : Told().messages) {
    const nlohmann::ordered_json body = Body(message);
    if (!body.contains("step")) continue;
    EXPECT_GE(body["step"].get<int>(), step[message.channel]) << message.channel;
    step[message.channel] = body["step"];
    if (!body.contains("piece")) continue;
    int& next = expected[message.channel];
    EXPECT_EQ(body["piece"].get<int>(), next) << message.channel;
    next = body["piece"] == body["pieces"].get<int>() - 1 ? 0 : next + 1;
  }
  for (const auto& [channel, next] : expected) EXPECT_EQ(next, 0) << channel << " misses pieces";
}

TEST(MissionMessages, AreTheSameForTheSameSeedButForTheTimeTaken) {
  KeepAll again;
  const SimulatedMission run({"threads=1"}, {&again});
  ASSERT_EQ(again.messages.size(), Told().messages.size());
  for (std::size_t i = 0; i < again.messages.size(); ++i) {
    ASSERT_EQ(again.messages[i].channel, Told().messages[i].channel);
    if (again.messages[i].channel == transport::channel::kTiming) continue;
    EXPECT_EQ(again.messages[i].bytes, Told().messages[i].bytes)
        << i << " on " << again.messages[i].channel;
  }
}

TEST(MissionMessages, DoNotChangeTheMission) {
  KeepAll sink;
  const SimulatedMission told({}, {&sink});
  const SimulatedMission silent({});
  EXPECT_EQ(told.Json(), silent.Json());
}

}  // namespace
}  // namespace secondlook::apps
