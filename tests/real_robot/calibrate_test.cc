#include <filesystem>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/make_robot.h"
#include "apps/run_config.h"
#include "lib/common/files.h"
#include "lib/kinematics/calibration_file.h"
#include "lib/perception/board.h"
#include "tests/support/program.h"
#include "tests/support/small_world.h"

namespace secondlook {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::RunProgram;

const perception::Board kBoard{7, 5, 0.08, 0.06};

/// A small world, and a board that can be put into it.
class Calibrate : public ::testing::Test {
 protected:
  /// A white sheet with the board in its middle, seen from M's -x, which all but lies on the table
  /// before a robot that has an arm.
  void PutBoard() const {
    geometry::Mesh sheet;
    const float w = 0.32F;
    const float h = 0.24F;
    sheet.vertices = {{0.0F, w, -h}, {0.0F, -w, -h}, {0.0F, -w, h}, {0.0F, w, h}};
    sheet.uv = {{0.0F, 0.0F}, {1.0F, 0.0F}, {1.0F, 1.0F}, {0.0F, 1.0F}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
    sheet.triangle_material = {0, 0};
    cv::Mat picture(480, 640, CV_8UC1, cv::Scalar(255));
    perception::DrawBoard(kBoard, 80).copyTo(picture(cv::Rect(40, 40, 560, 400)));
    geometry::Material material;
    cv::cvtColor(picture, material.texture, cv::COLOR_GRAY2RGB);
    sheet.materials = {material};
    geometry::SaveObj(sheet, world_ / "board");
    WriteFile(world_ / "scene.yaml",
              "table: {size: [0.5, 0.6], height: 0.75}\n"
              "floor: {size: [5, 5]}\nwalls: {}\n"
              "objects:\n  - {mesh: board/mesh.obj, unit: m, name: board, role: obstacle, "
              "position: [-0.1, 0, 0.78], pitch_deg: 85}\n"
              "robot: {position: [-0.75, 0], yaw_deg: 0}\n");
    WriteFile(world_.config(), "robot: !Sim\n  scene: scene.yaml\n  arm: {urdf: " +
                                   std::filesystem::absolute("sim/robots/arm.urdf").string() +
                                   "}\nmodels: models\n");
  }

  /// Within a millimetre and a tenth of a degree.
  static void ExpectNear(const Pose& found, const Pose& truth) {
    EXPECT_LT((found.translation() - truth.translation()).norm(), 0.001);
    EXPECT_LT(RotationDistance(found.linear(), truth.linear()) * 180.0 / std::numbers::pi, 0.1);
  }

  /// Where the camera truly sits in the head.
  Pose HeadTruth() const {
    const apps::RunConfig config = apps::LoadRunConfig(world_.config(), {});
    const apps::ReadyRobot ready = apps::MakeRobot(config.robot, config.seed);
    const sim::WorldState& state = ready.world->StateAt(ready.world->Now());
    const Pose X_BC = ToPose(state.X_WB).inverse() * ready.world->CameraPose(state);
    const Pose X_BH = CameraInBase({ready.calibration.X_BH0, Pose::Identity()}, state.head);
    return X_BH.inverse() * X_BC;
  }

  /// Where the camera truly sits in the hand.
  Pose HandTruth() const {
    const apps::RunConfig config = apps::LoadRunConfig(
        world_.config(), {"robot.noise.arm_sigma=0", "robot.noise.arm_sigma_deg=0"});
    const apps::ReadyRobot ready = apps::MakeRobot(config.robot, config.seed);
    const sim::WorldState& state = ready.world->StateAt(ready.world->Now());
    const Pose X_BC = ToPose(state.X_WB).inverse() * ready.world->HandCameraPose(state);
    return ready.hand->arm.TipPose(state.arm).inverse() * X_BC;
  }

  testing::SmallWorld world_;
  const std::string file_ = (world_ / "c.yaml").string();
};

TEST_F(Calibrate, FindsWhereTheCamerasOfHeadAndHandTrulySit) {
  PutBoard();
  const ProgramResult result =
      RunProgram({"calibrate", "--hand", "--config", world_.config().string(), "--out", file_});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out,
              ContainsRegex("head camera: [5-8][0-9] views, 0\\.[0-9]+ px: known to 0"));
  EXPECT_THAT(result.out,
              ContainsRegex("hand camera: [3-9][0-9] views, 0\\.[0-9]+ px: known to 0"));
  const kinematics::Calibration found = kinematics::LoadCalibration(file_);
  ExpectNear(found.head.X_HC, HeadTruth());
  ExpectNear(*found.X_EC, HandTruth());
  EXPECT_GE(found.hand_residuals->views, 30);

  // The simulated robot goes by the file, too.
  const apps::RunConfig config =
      apps::LoadRunConfig(world_.config(), {"robot.calibration=" + file_});
  const apps::ReadyRobot ready = apps::MakeRobot(config.robot, config.seed);
  EXPECT_TRUE(ready.hand->X_EC.isApprox(*found.X_EC, 1e-6));
  EXPECT_TRUE(ready.calibration.X_HC.isApprox(found.head.X_HC, 1e-6));
}

TEST_F(Calibrate, SaysThatThereIsNoArm) {
  const ProgramResult result =
      RunProgram({"calibrate", "--hand", "--config", world_.config().string(), "--out", "c.yaml"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, HasSubstr("has no arm with a camera in its hand"));
}

TEST_F(Calibrate, SaysThatNoBoardIsInSight) {
  const ProgramResult result =
      RunProgram({"calibrate", "--config", world_.config().string(), "--out", file_});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, HasSubstr("no board is in sight in"));
}

TEST_F(Calibrate, WritesABoardToPrint) {
  const std::string file = (world_ / "board.png").string();
  const ProgramResult result = RunProgram({"calibrate", "--board-image", file});
  EXPECT_EQ(result.status, 0) << result.out;
  EXPECT_THAT(result.out, HasSubstr("print it 0.560 m wide"));
  EXPECT_EQ(cv::imread(file).cols, 1400);
}

TEST_F(Calibrate, SaysWhatIsMissing) {
  const ProgramResult result = RunProgram({"calibrate", "--config", world_.config().string()});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, HasSubstr("give --config and --out, or --board-image alone"));
}

}  // namespace
}  // namespace secondlook
