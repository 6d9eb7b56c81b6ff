#include "lib/transport/message_json.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/transport/channels.h"
#include "lib/transport/message.h"
#include "tests/support/expect_throws.h"

#include "bot_core/images_t.hpp"
#include "second_look/candidates_t.hpp"
#include "second_look/command_t.hpp"
#include "second_look/look_t.hpp"
#include "second_look/mission_t.hpp"
#include "second_look/nav_goal_t.hpp"
#include "second_look/nav_status_t.hpp"
#include "second_look/objects_t.hpp"
#include "second_look/occupancy_t.hpp"
#include "second_look/status_t.hpp"
#include "second_look/support_plane_t.hpp"
#include "second_look/task_t.hpp"
#include "second_look/timing_t.hpp"
#include "second_look/view_t.hpp"

namespace secondlook::transport {
namespace {

second_look::task_t MakeTask() {
  second_look::task_t task;
  task.utime = 1'000'000;
  task.wanted.resize(1);
  task.wanted[0].name = "mug";
  task.wanted[0].confidence = 0.99;
  task.num_wanted = 1;
  task.confidence = 0.9;
  task.budget_looks = 20;
  task.budget_seconds = 600.0;
  task.budget_metres = std::numeric_limits<double>::quiet_NaN();
  return task;
}

TEST(Schema, FingerprintsAreThoseOfTheGeneratedTypes) {
  const Schema& schema = Schema::Messages();
  const auto same = [&](std::string_view type, std::int64_t generated) {
    EXPECT_EQ(schema.Fingerprint(type), static_cast<std::uint64_t>(generated)) << type;
  };
  same("bot_core.images_t", bot_core::images_t::getHash());
  same("second_look.candidates_t", second_look::candidates_t::getHash());
  same("second_look.command_t", second_look::command_t::getHash());
  same("second_look.look_t", second_look::look_t::getHash());
  same("second_look.mission_t", second_look::mission_t::getHash());
  same("second_look.nav_goal_t", second_look::nav_goal_t::getHash());
  same("second_look.nav_status_t", second_look::nav_status_t::getHash());
  same("second_look.objects_t", second_look::objects_t::getHash());
  same("second_look.occupancy_t", second_look::occupancy_t::getHash());
  same("second_look.status_t", second_look::status_t::getHash());
  same("second_look.support_plane_t", second_look::support_plane_t::getHash());
  same("second_look.task_t", second_look::task_t::getHash());
  same("second_look.timing_t", second_look::timing_t::getHash());
  same("second_look.view_t", second_look::view_t::getHash());
}

TEST(Schema, KnowsTheTypeOnEveryChannel) {
  for (const ChannelType& c : Channels()) {
    EXPECT_FALSE(Schema::Messages().Of(c.type).fields.empty()) << c.channel;
  }
}

TEST(Schema, NamesTheLineOfWhatItCannotRead) {
  EXPECT_THROWS(Schema({"package p;\nstruct a {\n  double x\n}"}), InvalidArgument,
                "line 4: expected ';', found '}'");
}

TEST(MessageJson, ShowsEveryFieldByItsName) {
  const nlohmann::ordered_json json = ToJson(Encode(MakeTask()), "second_look.task_t");
  EXPECT_EQ(json.dump(),
            R"({"utime":1000000,"num_wanted":1,"wanted":[{"name":"mug","confidence":0.99}],)"
            R"("confidence":0.9,"budget_looks":20,"budget_seconds":600.0,"budget_metres":null})");
}

TEST(MessageJson, ShowsBytesInBase64) {
  second_look::occupancy_t map{};
  map.blocks.resize(1);
  map.num_blocks = 1;
  std::fill_n(map.blocks[0].free, 64, std::uint8_t{0});
  std::fill_n(map.blocks[0].occupied, 64, std::uint8_t{0});
  map.blocks[0].free[0] = 'M';
  map.blocks[0].free[1] = 'a';
  map.blocks[0].free[2] = 'n';
  const auto json = ToJson(Encode(map), "second_look.occupancy_t");
  // "Man" is "TWFu" in RFC 4648; then 61 zero bytes: 20 groups and one byte.
  EXPECT_EQ(json["blocks"][0]["free"], "TWFu" + std::string(81, 'A') + "A==");
}

TEST(MessageJson, RefusesAnotherType) {
  EXPECT_THROWS(ToJson(Encode(MakeTask()), "second_look.command_t"), ProtocolError,
                "second_look.command_t: fingerprint");
}

TEST(MessageJson, RefusesAMessageCutOffAnywhere) {
  const std::vector<std::uint8_t> bytes = Encode(MakeTask());
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_THROW(Check(std::span(bytes).first(n), "second_look.task_t"), ProtocolError) << n;
  }
}

TEST(MessageJson, RefusesBytesLeftOver) {
  std::vector<std::uint8_t> bytes = Encode(MakeTask());
  bytes.push_back(0);
  EXPECT_THROWS(Check(bytes, "second_look.task_t"), ProtocolError, "1 bytes left over");
}

TEST(MessageJson, RefusesACountThatTheMessageCannotHold) {
  std::vector<std::uint8_t> bytes = Encode(MakeTask());
  bytes[16] = 0x7f;  // num_wanted follows the fingerprint and utime, most significant byte first
  EXPECT_THROWS(Check(bytes, "second_look.task_t"), ProtocolError, "'wanted' would have");
  bytes[16] = 0xff;
  EXPECT_THROWS(Check(bytes, "second_look.task_t"), ProtocolError, "a count");
}

TEST(MessageJson, SurvivesAnyDamage) {
  Rng rng(7);
  const std::vector<std::uint8_t> whole = Encode(MakeTask());
  for (int i = 0; i < 20'000; ++i) {
    std::vector<std::uint8_t> bytes = whole;
    for (int k = 0; k < 3; ++k) {
      bytes[8 + rng.Bits() % (bytes.size() - 8)] = static_cast<std::uint8_t>(rng.Bits());
    }
    try {
      const std::string text = ToJson(bytes, "second_look.task_t").dump();
      EXPECT_FALSE(text.empty());
    } catch (const ProtocolError&) {  // the other allowed answer
    }
  }
}

TEST(Check, RefusesFromOutsideWhatKeepsToTheSchemaButNotToReason) {
  const Limits limits{200, 2, 10};
  second_look::task_t task = MakeTask();
  const auto refuses = [&](const std::string& why) {
    EXPECT_NO_THROW(Check(Encode(task), "second_look.task_t")) << why;
    EXPECT_THROWS(Check(Encode(task), "second_look.task_t", limits), ProtocolError, why);
  };
  refuses("'budget_metres' is not finite");
  task.budget_metres = 60.0;
  EXPECT_NO_THROW(Check(Encode(task), "second_look.task_t", limits));
  task.wanted[0].confidence = std::numeric_limits<double>::infinity();
  refuses("'confidence' is not finite");
  task.wanted[0] = {"12345678901", 0.9};
  refuses("'name' has 11 characters, at most 10 are taken");
  task.wanted[0].name = "mug\n";
  refuses("'name' is not UTF-8 or has control characters");
  task.wanted[0].name = "m\xc3g";
  refuses("'name' is not UTF-8 or has control characters");
  task.wanted[0].name = "m\xc3\xbcg";
  EXPECT_NO_THROW(Check(Encode(task), "second_look.task_t", limits));
  task.wanted.resize(3);
  task.num_wanted = 3;
  refuses("'wanted' has 3 values, at most 2 are taken");
  task.wanted.resize(20);
  task.num_wanted = 20;
  refuses("bytes long, at most 200 are taken");
}

}  // namespace
}  // namespace secondlook::transport
