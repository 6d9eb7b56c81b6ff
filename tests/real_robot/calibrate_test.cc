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

/// A small world with a board that leans on its table.
class Calibrate : public ::testing::Test {
 protected:
  /// A white sheet with the board in its middle, standing up, seen from M's -x.
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
              "table: {size: [1.2, 0.8], height: 0.75}\n"
              "objects:\n  - {mesh: board/mesh.obj, unit: m, name: board, role: obstacle, "
              "position: [-0.2, 0, 1.0], pitch_deg: 25}\n"
              "robot: {position: [-1.05, 0], yaw_deg: 0}\n");
  }

  ProgramResult Run(const std::string& seed) const {
    return RunProgram({"calibrate", "--config", world_.config().string(), "--set", "seed=" + seed,
                       "--out", (world_ / "c.yaml").string()});
  }

  /// Where the camera of the robot with this seed truly sits in its head.
  Pose Truth(const std::string& seed) const {
    const apps::RunConfig config = apps::LoadRunConfig(world_.config(), {"seed=" + seed});
    const apps::ReadyRobot ready = apps::MakeRobot(config.robot, config.seed);
    const sim::WorldState& state = ready.world->StateAt(ready.world->Now());
    const Pose X_BC = ToPose(state.X_WB).inverse() * ready.world->CameraPose(state);
    const Pose X_BH = CameraInBase({ready.calibration.X_BH0, Pose::Identity()}, state.head);
    return X_BH.inverse() * X_BC;
  }

  testing::SmallWorld world_;
};

TEST_F(Calibrate, FindsWhereTheCameraTrulySits) {
  PutBoard();
  const ProgramResult result = Run("1");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, ContainsRegex("[5-8][0-9] views, 0\\.[0-9]+ px: known to 0\\.[0-9] mm"));
  const Pose found = kinematics::LoadCalibration(world_ / "c.yaml").head.X_HC;
  const Pose truth = Truth("1");
  EXPECT_LT((found.translation() - truth.translation()).norm(), 0.001) << result.out;
  EXPECT_LT(RotationDistance(found.linear(), truth.linear()) * 180.0 / std::numbers::pi, 0.1)
      << result.out;
}

TEST_F(Calibrate, SaysThatNoBoardIsInSight) {
  const ProgramResult result = Run("1");
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
