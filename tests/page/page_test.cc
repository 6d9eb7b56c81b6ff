#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/listener.h"
#include "apps/monitor_server.h"
#include "apps/page.h"
#include "apps/story.h"
#include "lib/common/files.h"
#include "lib/transport/channels.h"
#include "tests/page/browser.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

#include "bot_core/images_t.hpp"
#include "second_look/candidates_t.hpp"
#include "second_look/mission_t.hpp"
#include "second_look/nav_status_t.hpp"
#include "second_look/objects_t.hpp"
#include "second_look/occupancy_t.hpp"
#include "second_look/status_t.hpp"
#include "second_look/support_plane_t.hpp"
#include "second_look/timing_t.hpp"
#include "second_look/view_t.hpp"

namespace secondlook::apps {
namespace {

using testing::Draw;
using testing::Drawn;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace channel = transport::channel;

/// What a page says in bright text to be read: WCAG 2, level AA.
constexpr double kLevelAA = 4.5;

class PageInBrowser : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!testing::HaveBrowser()) {
      GTEST_SKIP() << "chromium is missing: apt-get install chromium (./launch test does, as root)";
    }
  }
};

std::string JpegOf(int width, int height) {
  std::vector<unsigned char> jpeg;
  cv::imencode(".jpg", cv::Mat(height, width, CV_8UC3, cv::Scalar(90, 120, 150)), jpeg);
  return {jpeg.begin(), jpeg.end()};
}

/// A mission of one step in which every text that comes from outside is `text`.
std::string PageOfTexts(const std::string& text) {
  Story story;
  second_look::mission_t mission{};
  mission.version = mission.config = mission.end = text;
  mission.models = {text};
  mission.num_models = 1;
  mission.task.wanted.resize(mission.task.num_wanted = 1);
  mission.task.wanted[0].name = text;
  mission.modelled.resize(mission.num_modelled = 1);
  mission.modelled[0].model = mission.modelled[0].reason = text;
  story.Post(transport::Pack(channel::kMission, mission));

  bot_core::images_t images{};
  const std::string jpeg = JpegOf(64, 48);
  images.image_types = {bot_core::images_t::LEFT};
  images.images.resize(images.n_images = 1);
  images.images[0].width = 64;
  images.images[0].height = 48;
  images.images[0].data.assign(jpeg.begin(), jpeg.end());
  images.images[0].size = static_cast<std::int32_t>(jpeg.size());
  story.Post(transport::Pack(channel::kImage, images));

  second_look::view_t view{};
  view.step = view.pieces = 1;
  view.camera.width = 64;
  view.camera.fx = 60;
  view.X_WC.q[0] = 1.0;
  view.detections.resize(view.num_detections = 1);
  view.detections[0].contour = {{10, 20}, {30, 20}, {30, 40}};
  view.detections[0].num_contour = 3;
  view.detections[0].reason = text;
  view.detections[0].hypotheses.resize(view.detections[0].num_hypotheses = 1);
  view.detections[0].hypotheses[0].model = text;
  view.detections[0].hypotheses[0].verification.reason = text;
  story.Post(transport::Pack(channel::kView, view));

  second_look::objects_t objects{};
  objects.step = objects.pieces = 1;
  objects.objects.resize(objects.num_objects = 2);
  for (second_look::object_t& object : objects.objects) {
    object.id = static_cast<std::int32_t>(&object - objects.objects.data());
    object.state = object.id == 0 ? "verified" : text;
    object.class_name = object.reason = text;
    object.posterior.resize(object.num_posterior = 1);
    object.posterior[0].name = text;
    object.posterior[0].probability = 0.75;
    object.hypotheses.resize(object.num_hypotheses = 1);
    object.hypotheses[0].model = object.hypotheses[0].reason = text;
    object.hypotheses[0].struck = 1;
    object.hypotheses[0].evidence.resize(object.hypotheses[0].num_evidence = 1);
    object.hypotheses[0].evidence[0].verification.reason = text;
  }
  story.Post(transport::Pack(channel::kObjects, objects));

  second_look::candidates_t candidates{};
  candidates.step = candidates.pieces = 1;
  candidates.looks.resize(candidates.num_looks = 1);
  candidates.looks[0].kind = candidates.looks[0].reason = text;
  story.Post(transport::Pack(channel::kCandidates, candidates));
  second_look::look_t look = candidates.looks[0];
  look.step = 1;
  story.Post(transport::Pack(channel::kLook, look));

  second_look::nav_status_t status{};
  status.step = 1;
  status.phase = second_look::nav_status_t::FAILED;
  status.reason = text;
  story.Post(transport::Pack(channel::kNavStatus, status));

  second_look::timing_t timing{};
  timing.step = 1;
  timing.stages.resize(timing.num_stages = 1);
  timing.stages[0].name = text;
  story.Post(transport::Pack(channel::kTiming, timing));
  return Page(story.All());
}

/// How often `text` stands in `page`.
int Count(const std::string& text, const std::string& page) {
  int count = 0;
  for (std::size_t i = 0; (i = page.find(text, i)) != std::string::npos; ++i) ++count;
  return count;
}

TEST_F(PageInBrowser, ExplainsTheDefaultMissionInLightAndDarkOnScreensWideAndNarrow) {
  const TemporaryFolder folder;
  const testing::ProgramResult run = testing::RunProgram(
      {"run", "--config", "config/sim.yaml", "--report", folder.path().string()});
  ASSERT_EQ(run.status, 0) << run.err;
  const std::string page = ReadFile(folder / "report.html");
  EXPECT_LT(page.size(), 2'000'000U) << "of four looks; 5 MB must do for twenty";
  const int images = Count("\"SECONDLOOK_IMAGE\"", page);
  EXPECT_GT(images, 1);

  const Drawn light = Draw(page);
  const Drawn dark = Draw(page, true);
  const Drawn narrow = Draw(page, false, 500);
  const auto mission = nlohmann::json::parse(ReadFile(folder / "mission.json"));
  int found = 0;
  for (const auto& object : mission["objects"]) {
    if (object["state"] != "verified") continue;
    EXPECT_THAT(light.headline, HasSubstr(object["class"].get<std::string>()));
    ++found;
  }
  EXPECT_GT(found, 0);
  EXPECT_THAT(light.text, HasSubstr(mission["end"].get<std::string>()));
  for (const Drawn& drawn : {light, dark, narrow}) {
    EXPECT_THAT(drawn.faults, IsEmpty());
    EXPECT_EQ(drawn.broken, 0);
    // The strip is drawn at first and for each step that is chosen, and that step's view large.
    EXPECT_GT(drawn.pictures, images * images);
    EXPECT_GE(drawn.lowest_contrast, kLevelAA);
    EXPECT_FALSE(drawn.overflows);
  }
  EXPECT_NE(light.background, dark.background);
}

TEST_F(PageInBrowser, SaysSoWhenThereWasNoMission) {
  const Drawn drawn = Draw(Page(Story().All()));
  EXPECT_THAT(drawn.faults, IsEmpty());
  EXPECT_EQ(drawn.headline, "No mission yet.");
}

TEST_F(PageInBrowser, TellsAMissionThatEndedBeforeItsFirstView) {
  Story story;
  second_look::mission_t mission{};
  mission.end = "stopped on request";
  story.Post(transport::Pack(channel::kMission, mission));
  const Drawn drawn = Draw(Page(story.All()));
  EXPECT_THAT(drawn.faults, IsEmpty());
  EXPECT_THAT(drawn.text, HasSubstr("stopped on request"));
}

TEST_F(PageInBrowser, ShowsHowMuchOfAThingWasSeenAfterEachScan) {
  Story story;
  second_look::mission_t mission{};
  mission.end = "everything is settled";
  mission.modelled.resize(mission.num_modelled = 2);
  mission.modelled[0].model = "object_1";
  mission.modelled[0].coverage = {0.41, 0.66, 0.97};
  mission.modelled[0].num_scans = 3;
  mission.modelled[0].reason = "enough of it is seen: 97 %";
  mission.modelled[1].object_id = 4;
  mission.modelled[1].reason = "is 0.61 m long";
  story.Post(transport::Pack(channel::kMission, mission));
  const Drawn drawn = Draw(Page(story.All()));
  EXPECT_THAT(drawn.faults, IsEmpty());
  EXPECT_THAT(drawn.text, HasSubstr("Object 0: object_1"));
  EXPECT_THAT(drawn.text, HasSubstr("3 scans, 97 % seen; enough of it is seen"));
  EXPECT_THAT(drawn.text, HasSubstr("Object 4: no model"));
  EXPECT_THAT(drawn.elements, HasSubstr("polyline"));
}

TEST_F(PageInBrowser, TakesTextFromOutsideAsTextAlone) {
  const std::string elements = Draw(PageOfTexts("harmless")).elements;
  for (const std::string hostile :
       {"<img src=x onerror=alert(1)>", "</script><script>alert(1)</script>", "${alert(1)}",
        "\"'><svg onload=alert(1)>", "__proto__"}) {
    const Drawn drawn = Draw(PageOfTexts(hostile));
    EXPECT_THAT(drawn.faults, IsEmpty()) << hostile;
    EXPECT_THAT(drawn.headline, HasSubstr(hostile));
    EXPECT_EQ(drawn.broken, 0) << "a picture that is not ours";
    EXPECT_EQ(drawn.elements, elements) << hostile;
  }
}

TEST_F(PageInBrowser, ShowsLiveWhatTheMonitorHears) {
  lcm::LCM lcm("memq://");
  Story story;
  Listener listener(&lcm, &story);
  const MonitorServer server(&story, &listener, 0);
  const std::string url = "http://127.0.0.1:" + std::to_string(server.port()) + "/";
  EXPECT_THAT(testing::ElementsAt(url), HasSubstr("No mission yet."));

  second_look::mission_t mission{};
  mission.seed = 4711;
  lcm.publish(channel::kMission, &mission);
  lcm.handleTimeout(0);
  second_look::status_t status{};
  status.phase = "moving";
  lcm.publish(channel::kStatus, &status);
  lcm.handleTimeout(0);
  const std::string elements = testing::ElementsAt(url);
  EXPECT_THAT(elements, HasSubstr("live · seed 4711"));
  EXPECT_THAT(elements, HasSubstr("It is looking for a table."));
  EXPECT_THAT(elements, HasSubstr("<strong>moving</strong>"));
}

}  // namespace
}  // namespace secondlook::apps
