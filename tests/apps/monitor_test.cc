#include <string>

#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>

#include "apps/http.h"
#include "apps/listener.h"
#include "apps/monitor_server.h"
#include "apps/story.h"
#include "lib/common/error.h"
#include "lib/transport/channels.h"
#include "tests/support/expect_throws.h"

#include "second_look/mission_t.hpp"
#include "second_look/status_t.hpp"
#include "second_look/view_t.hpp"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;
namespace channel = transport::channel;

class Monitor : public ::testing::Test {
 protected:
  void Publish(const std::string& on, const std::vector<std::uint8_t>& bytes) {
    lcm_.publish(on, bytes.data(), static_cast<unsigned>(bytes.size()));
    lcm_.handleTimeout(0);
  }

  template <class T>
  void Publish(const char* on, const T& body) {
    Publish(std::string(on), transport::Encode(body));
  }

  void PublishView(int step) {
    second_look::view_t view{};
    view.step = step;
    view.pieces = 1;
    Publish(channel::kView, view);
  }

  void PublishMission(std::int64_t seed) {
    second_look::mission_t mission{};
    mission.seed = seed;
    Publish(channel::kMission, mission);
  }

  httplib::Result Get(const std::string& path, const httplib::Headers& headers = {}) const {
    return httplib::Client("127.0.0.1", server_.port()).Get(path, headers);
  }

  /// What a browser is given that has come as far as the last answer said.
  Json Poll(const Json& last = {{"story", 0}, {"next", 0}}) const {
    return Json::parse(
        Get("/messages?story=" + last["story"].dump() + "&from=" + last["next"].dump())->body);
  }

  lcm::LCM lcm_{"memq://"};
  Story story_;
  Listener listener_{&lcm_, &story_};
  MonitorServer server_{&story_, &listener_, 0};
};

TEST_F(Monitor, ServesThePage) {
  const auto page = Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_EQ(page->get_header_value("Content-Type"), "text/html; charset=utf-8");
  EXPECT_NE(page->body.find(R"(id="story">{"live":true}</script>)"), std::string::npos);
}

TEST_F(Monitor, IsThereBeforeAnyMission) {
  const Json answer = Poll();
  EXPECT_EQ(answer["messages"], Json::array());
  EXPECT_EQ(answer["status"], nullptr);
  EXPECT_EQ(answer["status_age"], nullptr);
}

TEST_F(Monitor, BringsEveryBrowserWhatIsNewToIt) {
  PublishMission(3);
  const Json early = Poll();
  ASSERT_EQ(early["messages"].size(), 1U);
  EXPECT_EQ(early["messages"][0]["message"]["seed"], 3);
  PublishView(1);
  const Json news = Poll(early);
  ASSERT_EQ(news["messages"].size(), 1U);
  EXPECT_EQ(news["messages"][0]["channel"], "SECONDLOOK_VIEW");
  EXPECT_EQ(Poll(news)["messages"], Json::array());
  EXPECT_EQ(Poll()["messages"].size(), 2U) << "another browser, which comes late";
}

TEST_F(Monitor, SaysHowTheProcessIs) {
  second_look::status_t status{};
  status.phase = "moving";
  Publish(channel::kStatus, status);
  const Json answer = Poll();
  EXPECT_EQ(answer["status"]["phase"], "moving");
  EXPECT_TRUE(answer["status_age"].is_number());
}

TEST_F(Monitor, TellsANewMissionFromItsBeginning) {
  PublishMission(1);
  PublishView(1);
  PublishView(2);
  const Json first = Poll();
  PublishMission(2);
  PublishView(1);
  const Json second = Poll(first);
  EXPECT_NE(second["story"], first["story"]);
  ASSERT_EQ(second["messages"].size(), 2U);
  EXPECT_EQ(second["messages"][0]["message"]["seed"], 2);
  EXPECT_EQ(second["server"], first["server"]);
}

TEST_F(Monitor, CountsGarbageAndShowsNothingOfIt) {
  PublishView(1);
  Publish(std::string(channel::kObjects), {1, 2, 3});
  Publish("SECONDLOOK_NONSENSE", {1, 2, 3});
  Publish(std::string(channel::kImage), std::vector<std::uint8_t>(100'001));
  const Json answer = Poll();
  EXPECT_EQ(answer["messages"].size(), 1U);
  EXPECT_EQ(answer["rejected"], 3);
  EXPECT_EQ(answer["last_rejected"], "SECONDLOOK_IMAGE: 100001 bytes; at most 100000 are right");
}

TEST_F(Monitor, RefusesAForeignHost) {
  const std::string port = std::to_string(server_.port());
  EXPECT_EQ(Get("/", {{"Host", "localhost:" + port}})->status, 200);
  for (const char* path : {"/", "/messages"}) {
    EXPECT_EQ(Get(path, {{"Host", "evil.example:" + port}})->status, 403);
    EXPECT_EQ(Get(path, {{"Host", "127.0.0.1"}})->status, 403) << "of another server";
  }
}

TEST_F(Monitor, RefusesWhatIsNoNumber) {
  for (const char* query : {"story=x&from=0", "story=1&from=-1", "story=1&from=1e3"}) {
    EXPECT_EQ(Get(std::string("/messages?") + query)->status, 400) << query;
  }
}

TEST_F(Monitor, LetsNothingBeWritten) {
  httplib::Client client("127.0.0.1", server_.port());
  for (const char* path : {"/", "/messages", "/story"}) {
    EXPECT_EQ(client.Post(path, "{}", "application/json")->status, 404) << path;
    EXPECT_EQ(client.Put(path, "{}", "application/json")->status, 404) << path;
    EXPECT_EQ(client.Delete(path)->status, 404) << path;
  }
}

TEST_F(Monitor, SaysWhenItsPortIsTaken) {
  EXPECT_THROWS(MonitorServer(&story_, &listener_, server_.port()), ConfigError,
                "cannot be had; end what uses it, or choose another with --port");
}

}  // namespace
}  // namespace secondlook::apps
