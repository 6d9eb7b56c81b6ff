#include "apps/story.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "apps/page.h"
#include "lib/common/error.h"
#include "lib/transport/channels.h"
#include "tests/support/expect_throws.h"

#include "bot_core/images_t.hpp"
#include "second_look/candidates_t.hpp"
#include "second_look/mission_t.hpp"
#include "second_look/nav_goal_t.hpp"
#include "second_look/nav_status_t.hpp"
#include "second_look/objects_t.hpp"
#include "second_look/occupancy_t.hpp"
#include "second_look/status_t.hpp"
#include "second_look/view_t.hpp"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;
namespace channel = transport::channel;

Json Messages(const StoryPart& part) { return Json::parse(part.messages); }

template <class T>
T InOnePiece(int step) {
  T body{};
  body.utime = 1'000'000 * step;
  body.step = step;
  body.pieces = 1;
  return body;
}

transport::Message MissionBegins(std::int64_t utime) {
  second_look::mission_t mission{};
  mission.utime = utime;
  return transport::Pack(channel::kMission, mission);
}

transport::Message MissionEnds(std::int64_t utime, const std::string& why) {
  second_look::mission_t mission{};
  mission.utime = utime;
  mission.end = why;
  return transport::Pack(channel::kMission, mission);
}

transport::Message View(int step) {
  return transport::Pack(channel::kView, InOnePiece<second_look::view_t>(step));
}

/// One object with one hypothesis, of which one view says something.
transport::Message Objects(int step) {
  auto objects = InOnePiece<second_look::objects_t>(step);
  objects.objects.resize(objects.num_objects = 1);
  second_look::object_t& object = objects.objects[0];
  object.p_WO[0] = 1.0 / 3.0;
  object.hypotheses.resize(object.num_hypotheses = 1);
  object.hypotheses[0].evidence.resize(object.hypotheses[0].num_evidence = 1);
  return transport::Pack(channel::kObjects, objects);
}

transport::Message NavStatus(int step, int phase, double x) {
  second_look::nav_status_t status{};
  status.utime = 1'000'000 * step;
  status.step = step;
  status.phase = static_cast<std::int8_t>(phase);
  status.X_WB[0] = x;
  return transport::Pack(channel::kNavStatus, status);
}

Json OnlyMessage(const transport::Message& message) {
  Story story;
  story.Post(message);
  const Json messages = Messages(story.All());
  return messages.size() == 1 ? messages[0]["message"] : Json();
}

TEST(Story, KeepsColourAndDropsDepth) {
  bot_core::images_t images{};
  images.utime = 7;
  images.image_types = {bot_core::images_t::DEPTH_MM_ZIPPED, bot_core::images_t::LEFT};
  images.images.resize(images.n_images = 2);
  images.images[0].data = {1, 2, 3, 4};
  images.images[0].size = 4;
  images.images[1].data = {'f', 'o', 'o'};
  images.images[1].size = 3;
  images.images[1].width = 640;
  images.images[1].height = 480;
  EXPECT_EQ(
      OnlyMessage(transport::Pack(channel::kImage, images)),
      Json::parse(R"({"utime": 7, "images": [{"width": 640, "height": 480, "data": "Zm9v"}]})"));
}

TEST(Story, RoundsToATenthOfAMillimetreAndDropsCovariances) {
  const Json object = OnlyMessage(Objects(1))["objects"][0];
  EXPECT_EQ(object["p_WO"][0], 0.3333);
  EXPECT_FALSE(object.contains("covariance"));
  EXPECT_FALSE(object["hypotheses"][0].contains("X_WM"));
  EXPECT_EQ(object["hypotheses"][0]["evidence"].size(), 1U);
}

TEST(Story, KeepsOfCandidatesWhereTheyAreAndWhatTheyAreWorthOrWhyTheyAreRefused) {
  auto candidates = InOnePiece<second_look::candidates_t>(1);
  candidates.looks.resize(candidates.num_looks = 2);
  for (second_look::look_t& look : candidates.looks) {
    look.path_W.resize(look.num_path = 2, {0.0, 0.0, 0.0});
    look.checks.resize(look.num_checks = 3);
    look.X_WB[0] = 1.5;
  }
  candidates.looks[0].feasible = 1;
  candidates.looks[0].score = 0.5;
  candidates.looks[1].reason = "collision: with the map";
  const Json looks = OnlyMessage(transport::Pack(channel::kCandidates, candidates))["looks"];
  EXPECT_EQ(looks[0]["score"], 0.5);
  EXPECT_EQ(looks[1]["reason"], "collision: with the map");
  EXPECT_FALSE(looks[1].contains("score"));
  for (const Json& look : looks) {
    EXPECT_EQ(look["X_WB"][0], 1.5);
    EXPECT_FALSE(look.contains("path_W"));
    EXPECT_FALSE(look.contains("checks"));
  }
}

TEST(Story, KeepsOfTheMapWhatIsOccupiedAndThatABlockHasBecomeEmpty) {
  auto map = InOnePiece<second_look::occupancy_t>(1);
  map.blocks.resize(map.num_blocks = 2);
  map.blocks[0].free[0] = 1;
  map.blocks[1].occupied[63] = 0x80;
  const Json blocks = OnlyMessage(transport::Pack(channel::kOccupancy, map))["blocks"];
  EXPECT_FALSE(blocks[0].contains("free"));
  EXPECT_EQ(blocks[0]["occupied"], "");
  EXPECT_EQ(blocks[1]["occupied"], std::string(84, 'A') + "gA==");  // 63 zero bytes, then 0x80
}

TEST(Story, PassesOverWhatThePageDoesNotShow) {
  Story story;
  story.Post(transport::Pack(channel::kNavGoal, second_look::nav_goal_t{}));
  story.Post({"SOMEBODY_ELSE", 0, {1, 2, 3}});
  EXPECT_EQ(story.All().messages, "[]");
}

TEST(Story, GivesWhatIsNewOrAllOfAnotherStory) {
  Story story;
  story.Post(MissionBegins(1));
  const StoryPart first = story.All();
  story.Post(View(1));
  const Json news = Messages(story.Since(first.story, first.next));
  ASSERT_EQ(news.size(), 1U);
  EXPECT_EQ(news[0]["channel"], "SECONDLOOK_VIEW");
  EXPECT_EQ(news[0]["utime"], 1'000'000);
  EXPECT_EQ(Messages(story.Since(first.story + 1, first.next)).size(), 2U);
}

TEST(Story, BeginsAnewWithANewMission) {
  Story story;
  story.Post(MissionBegins(1));
  story.Post(View(1));
  story.Post(MissionEnds(2, "everything is settled"));
  const StoryPart first = story.All();
  EXPECT_EQ(Messages(first).size(), 2U) << "the end stands in for the beginning";
  story.Post(MissionBegins(1));  // the same mission once more, as a simulation does it
  const StoryPart second = story.Since(first.story, first.next);
  EXPECT_NE(second.story, first.story);
  ASSERT_EQ(Messages(second).size(), 1U);
  EXPECT_EQ(Messages(second)[0]["message"]["end"], "");
}

TEST(Story, BeginsAnewWhenStepsCountFromOneAgain) {
  Story story;
  story.Post(MissionBegins(1));
  story.Post(View(1));
  story.Post(View(2));
  const StoryPart first = story.All();
  story.Post(MissionBegins(1));  // after a crash, not after an end
  story.Post(View(1));
  const StoryPart second = story.All();
  EXPECT_NE(second.story, first.story);
  const Json messages = Messages(second);
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[0]["channel"], "SECONDLOOK_MISSION");
  EXPECT_EQ(messages[1]["message"]["step"], 1);
}

TEST(Story, BeginsAnewWhenTheFirstStepIsSeenTwice) {
  Story story;
  story.Post(View(1));
  story.Post(View(1));
  EXPECT_EQ(Messages(story.All()).size(), 1U);
}

TEST(Story, GoesOnWhenTheMissionIsToldOnceMore) {
  Story story;
  story.Post(MissionBegins(1));
  story.Post(View(1));
  story.Post(MissionBegins(1));
  EXPECT_EQ(Messages(story.All()).size(), 2U);
}

TEST(Story, KeepsEvidenceOfTheNewestStepOnly) {
  Story story;
  story.Post(Objects(1));
  story.Post(Objects(2));
  const Json messages = Messages(story.All());
  const auto evidence = [&](int i) {
    return messages[i]["message"]["objects"][0]["hypotheses"][0]["evidence"].size();
  };
  EXPECT_EQ(evidence(0), 0U);
  EXPECT_EQ(evidence(1), 1U);
}

TEST(Story, KeepsOfAWayItsEndsAndPiecesOfSomeCentimetres) {
  Story story;
  using second_look::nav_status_t;
  story.Post(NavStatus(1, nav_status_t::MOVING, 0.0));
  story.Post(NavStatus(1, nav_status_t::MOVING, 0.03));  // no news
  story.Post(NavStatus(1, nav_status_t::MOVING, 0.05));
  story.Post(NavStatus(1, nav_status_t::REACHED, 0.05));
  story.Post(NavStatus(2, nav_status_t::MOVING, 0.05));
  std::vector<double> kept;
  for (const Json& entry : Messages(story.All())) kept.push_back(entry["message"]["X_WB"][0]);
  EXPECT_EQ(kept, (std::vector{0.0, 0.05, 0.05, 0.05}));
}

TEST(Story, KnowsTheNewestStatusOnly) {
  Story story;
  EXPECT_EQ(story.All().status, "null");
  second_look::status_t status{};
  for (const char* phase : {"grabbing", "moving"}) {
    status.phase = phase;
    story.Post(transport::Pack(channel::kStatus, status));
  }
  EXPECT_EQ(Json::parse(story.All().status)["phase"], "moving");
  EXPECT_EQ(story.All().messages, "[]");
}

TEST(Story, HasBoundsAndSaysHowMuchIsLeftOut) {
  Story story({.messages = 3, .bytes = 1'000'000});
  story.Post(MissionBegins(1));
  for (int step = 1; step <= 5; ++step) story.Post(View(step));
  const Json messages = Messages(story.All());
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_EQ(messages[0]["channel"], "SECONDLOOK_MISSION") << "it stays";
  EXPECT_EQ(messages[1]["message"]["step"], 4);
  EXPECT_EQ(story.All().left_out, 3U);

  Story small({.messages = 1000, .bytes = 1000});
  for (int step = 1; step <= 50; ++step) small.Post(View(step));
  EXPECT_LE(small.All().messages.size(), 1000U + 50 * 2);
  EXPECT_GT(small.All().left_out, 40U);
}

TEST(Story, RefusesGarbageAndKeepsWhatItHas) {
  Story story;
  story.Post(View(1));
  transport::Message cut = View(2);
  cut.bytes.pop_back();
  EXPECT_THROWS(story.Post(cut), ProtocolError, "cut off");
  EXPECT_THROWS(story.Post({channel::kObjects, 0, View(2).bytes}), ProtocolError, "another type");
  EXPECT_EQ(Messages(story.All()).size(), 1U);
}

TEST(Page, HoldsTheMessagesWhereNoTextCanEndThem) {
  Story story;
  story.Post(MissionEnds(1, "</script><script>alert(1)</script>"));
  const std::string page = Page(story.All());
  const std::string place = R"(id="story">)";
  const std::size_t begin = page.find(place) + place.size();
  const std::string json = page.substr(begin, page.find("</script>", begin) - begin);
  EXPECT_EQ(Json::parse(json)["messages"][0]["message"]["end"],
            "</script><script>alert(1)</script>");
}

TEST(Page, FetchesNothing) {
  const std::string page = Page(Story().All());
  EXPECT_EQ(page.find("src=\"http"), std::string::npos);
  EXPECT_EQ(page.find("@import"), std::string::npos);
  EXPECT_EQ(page.find("{{"), std::string::npos) << "a place that was not filled";
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

}  // namespace
}  // namespace secondlook::apps
