// The command line as scripts rely on it (docs/cli.md).

#include <cmath>
#include <csignal>
#include <cstdint>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "lib/common/files.h"
#include "lib/geometry/point_image.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/program.h"
#include "tests/support/small_world.h"

namespace secondlook {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramResult;
using testing::RunProgram;

const geometry::CameraModel kCamera{640, 480, 577.0, 577.0, 319.5, 239.5};

/// A block of 0.1 x 0.15 x 0.2 m on a table 0.75 m high, seen from 1.2 m away. NaN = none.
cv::Mat DepthOfABlock() {
  testing::AnalyticScene scene;
  Pose X_WTable = Pose::Identity();
  X_WTable.translation() = Eigen::Vector3d(0.0, 0.0, 0.735);
  Pose X_WBlock = Pose::Identity();
  X_WBlock.translation() = Eigen::Vector3d(0.0, 0.0, 0.85);
  X_WBlock.linear() = RotationFromRollPitchYaw(0.0, 0.0, 0.5);
  scene.boxes = {{X_WTable, {1.2, 0.8, 0.03}}, {X_WBlock, {0.1, 0.15, 0.2}}};
  return scene.Render(kCamera, testing::LookingAt({-1.0, 0.0, 1.4}, {0.0, 0.0, 0.8}));
}

/// In tenths of millimetres; 0 = none.
void WriteDepth(const cv::Mat& depth, const std::filesystem::path& file) {
  cv::Mat units(depth.size(), CV_16UC1, cv::Scalar(0));
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      if (std::isfinite(z)) {
        units.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(std::lround(z * 1e4));
      }
    }
  }
  cv::imwrite(file.string(), units);
}

void WriteCloud(const cv::Mat& depth, const std::filesystem::path& file) {
  std::string text =
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 640\n"
      "HEIGHT 480\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 307200\nDATA ascii\n";
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const double z = depth.at<float>(v, u);
      const Eigen::Vector3d p = kCamera.Ray(u, v) * z;
      text += std::isfinite(z) ? fmt::format("{:.5f} {:.5f} {:.5f}\n", p.x(), p.y(), p.z())
                               : std::string("nan nan nan\n");
    }
  }
  WriteFile(file, text);
}

TEST(Contract, SegmentWritesOneJsonObjectAndNothingElseToStandardOutput) {
  const testing::SmallWorld world;
  WriteCloud(DepthOfABlock(), world / "cloud.pcd");
  const std::string cloud = (world / "cloud.pcd").string();
  const ProgramResult pure = RunProgram({"segment", "--cloud", cloud, "--json", "-"});
  std::filesystem::remove("cloud-labels.png");  // `-` leaves the label image in the working folder
  ASSERT_EQ(pure.status, 0) << pure.err;
  const json result = json::parse(pure.out);
  EXPECT_EQ(result["clusters"].size(), 1U);
  EXPECT_GT(result["clusters"][0]["points"], 1000);
  EXPECT_EQ(result["clusters"][0]["center"].size(), 3U);
  ASSERT_EQ(result["plane"]["normal"].size(), 3U);
  // The table lies 0.65 m below the camera: normal . p = offset for its points.
  EXPECT_NEAR(result["plane"]["offset"], -0.65, 0.002);
  EXPECT_EQ(result["labels"], "cloud-labels.png");
  EXPECT_THAT(pure.err, HasSubstr("no --up given")) << "what is said goes to standard error";

  const std::string file = (world / "out" / "result.json").string();
  ASSERT_EQ(RunProgram({"segment", "--cloud", cloud, "--json", file}).status, 0);
  const json written = json::parse(ReadFile(file));
  EXPECT_EQ(written["clusters"], result["clusters"]);
  EXPECT_EQ(written["labels"], (world / "out" / "cloud-labels.png").string());
  EXPECT_FALSE(cv::imread(written["labels"], cv::IMREAD_UNCHANGED).empty());
}

TEST(Contract, RecogniseWritesOneJsonObjectAndNothingElseToStandardOutput) {
  const testing::SmallWorld world;
  WriteDepth(DepthOfABlock(), world / "depth.png");
  const ProgramResult pure = RunProgram(
      {"recognise", "--models", world.models().string(), "--depth", (world / "depth.png").string(),
       "--depth-unit", "0.0001", "--camera", "577,577,319.5,239.5", "--json", "-"});
  ASSERT_EQ(pure.status, 0) << pure.err;
  const json result = json::parse(pure.out);
  ASSERT_EQ(result["objects"].size(), 1U);
  const json& block = result["objects"][0];
  EXPECT_EQ(block["model"], "block");
  EXPECT_EQ(block["X_CM"].size(), 4U);
  EXPECT_EQ(block["X_CM"][3], json({0.0, 0.0, 0.0, 1.0}));
  EXPECT_TRUE(block["score"].is_number());
  EXPECT_TRUE(block["verified"].is_boolean());
  EXPECT_TRUE(result["seconds"].is_number());
  // The block's centre, (0, 0, 0.85) in W, lies on the camera's way to (0, 0, 0.8), 5 cm higher.
  const Pose X_CW = testing::LookingAt({-1.0, 0.0, 1.4}, {0.0, 0.0, 0.8}).inverse();
  const Eigen::Vector3d p_CM = X_CW * Eigen::Vector3d(0.0, 0.0, 0.85);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(block["X_CM"][i][3], p_CM[i], 0.005);
}

TEST(Contract, RecogniseSaysInItsResultWhyThereIsNoPlane) {
  const testing::SmallWorld world;
  WriteDepth(cv::Mat(480, 640, CV_32FC1, cv::Scalar(1.0)), world / "wall.png");
  const ProgramResult wall = RunProgram(
      {"recognise", "--models", world.models().string(), "--depth", (world / "wall.png").string(),
       "--depth-unit", "0.0001", "--camera", "577,577,319.5,239.5", "--json", "-"});
  ASSERT_EQ(wall.status, 0) << wall.err;
  const json result = json::parse(wall.out);
  EXPECT_TRUE(result["objects"].empty());
  EXPECT_THAT(result["reason"], HasSubstr("no support plane"));
}

TEST(Contract, RecogniseRefusesInputThatCannotBeRight) {
  const testing::SmallWorld world;
  WriteDepth(DepthOfABlock(), world / "depth.png");
  const auto run = [&](const std::string& unit, const std::string& camera) {
    return RunProgram({"recognise", "--models", world.models().string(), "--depth",
                       (world / "depth.png").string(), "--depth-unit", unit, "--camera", camera});
  };
  const ProgramResult far = run("1", "577,577,319.5,239.5");
  EXPECT_EQ(far.status, 2);
  EXPECT_THAT(far.err, HasSubstr("no table is that far: give the metres of one unit"));
  const ProgramResult other = run("0.0001", "577,577,999,239.5");
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, HasSubstr("lies outside the 640 x 480 depth image"));
}

TEST(Contract, AStopSignalFinishesTheFilesAndEndsWithItsStatus) {
  // A camera that delivers nothing keeps the mission waiting until the signal comes.
  const testing::SmallWorld world;
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string report = (world / fmt::format("report_{}", signal)).string();
    const ProgramResult result = RunProgram(
        {"run", "--config", world.config().string(), "--lcm-url", "none", "--report", report,
         "--set", "robot.camera_fault=nothing", "--set", "mission.looks.frame_tries=100000000"},
        {"look 1 (search)", signal});
    EXPECT_EQ(result.status, 128 + signal) << result.err;
    const json mission = json::parse(ReadFile(report + "/mission.json"));
    EXPECT_EQ(mission["end"], "stopped on request");
    EXPECT_EQ(mission["looks"].size(), 1U);
    EXPECT_TRUE(mission.contains("objects") && mission.contains("seconds") &&
                mission.contains("metres") && mission.contains("seed"));
    EXPECT_TRUE(std::filesystem::exists(report + "/config.yaml"));
  }
}

TEST(Contract, PlanOnlyMovesNothing) {
  const testing::SmallWorld world;
  const std::string report = (world / "report").string();
  const ProgramResult result = RunProgram({"run", "--config", world.config().string(), "--lcm-url",
                                           "none", "--plan-only", "--report", report});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("next look: "));
  const json mission = json::parse(ReadFile(report + "/mission.json"));
  EXPECT_EQ(mission["metres"], 0.0);
  EXPECT_EQ(mission["seconds"]["motion"], 0.0);
  EXPECT_GE(mission["seconds"]["total"], mission["seconds"]["compute"]);
}

TEST(Contract, ModelsAreListedAndRemoved) {
  const testing::SmallWorld world;
  const std::string models = world.models().string();
  EXPECT_THAT(RunProgram({"model", "list", "--models", models}).out, HasSubstr("block"));
  EXPECT_EQ(RunProgram({"model", "remove", "--name", "block", "--models", models}).status, 0);
  const ProgramResult again =
      RunProgram({"model", "remove", "--name", "block", "--models", models});
  EXPECT_EQ(again.status, 2);
  EXPECT_THAT(again.err, HasSubstr("there is no model named 'block'"));
}

}  // namespace
}  // namespace secondlook
