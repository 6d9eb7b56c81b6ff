#include "sim/sim_striper.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/sim/rig.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::sim {
namespace {

SimConfig Config(const NoiseConfig& noise) {
  SimConfig config;
  config.noise = noise;
  config.arm.emplace().urdf = "sim/robots/arm.urdf";
  config.arm->striper.emplace();
  return config;
}

/// Where the laser is by its files when the simulation begins.
Pose StartOfLaser(const Scene& scene) {
  const ArmSetup arm = LoadArm(*Config(NoiseConfig::None()).arm);
  return ToPose(Pose2{scene.robot.position.x(), scene.robot.position.y(),
                      scene.robot.yaw_deg / 180.0 * M_PI}) *
         arm.hand.arm.TipPose(arm.home) * arm.striper->X_EL;
}

/// A thin square board `distance` before the laser, turned about x_L by `tilt_deg` from facing it.
std::shared_ptr<SimulatedRobot> BeforeABoard(double distance, double tilt_deg,
                                             const NoiseConfig& noise,
                                             const geometry::Material& material = {}) {
  Scene scene = FreeScene();
  geometry::Mesh board_W = geometry::MakeBox({0.4, 0.4, 0.006}, {1.0F, 1.0F, 1.0F});
  board_W.materials.at(0) = material;
  Pose X_LM = Pose::Identity();
  X_LM.linear() = RotationFromRollPitchYaw(tilt_deg / 180.0 * M_PI, 0.0, 0.0);
  X_LM.translation() = Eigen::Vector3d(0.0, 0.0, distance) + 0.003 * X_LM.linear().col(2);
  const Pose X_WM = StartOfLaser(scene) * X_LM;
  for (Eigen::Vector3f& vertex : board_W.vertices) {
    vertex = (X_WM * vertex.cast<double>()).cast<float>();
  }
  const TemporaryFolder folder;
  geometry::SaveObj(board_W, folder.path());
  SceneObject board;
  board.mesh = (folder.path() / "mesh.obj").string();
  board.name = "board";
  board.role = "obstacle";
  board.position = {0.0, 0.0, 0.0};
  scene.objects.push_back(board);
  return MakeShared(scene, Config(noise), 3);
}

std::vector<hal::ScanLine> Lines(SimulatedRobot* simulated, double seconds) {
  hal::LaserStriper& striper = *simulated->robot.striper;
  hal::Arm& arm = *simulated->robot.arm;
  striper.On();
  std::vector<hal::ScanLine> lines;
  const Time end = simulated->world->Now() + Seconds(seconds);
  while (simulated->world->Now() < end) {
    simulated->world->Step();
    for (hal::ScanLine& line : striper.Take()) lines.push_back(std::move(line));
  }
  EXPECT_EQ(arm.Status().phase, hal::MotionPhase::kIdle);
  return lines;
}

int Returns(const std::vector<hal::ScanLine>& lines) {
  int returns = 0;
  for (const hal::ScanLine& line : lines) {
    for (const float range : line.ranges) returns += std::isnan(range) ? 0 : 1;
  }
  return returns;
}

TEST(SimStriper, MeasuresAlongItsRays) {
  const auto simulated = BeforeABoard(0.5, 0.0, NoiseConfig::None());
  const hal::StriperInfo& info = simulated->robot.striper->info();
  const std::vector<hal::ScanLine> lines = Lines(simulated.get(), 0.1);
  ASSERT_EQ(lines.size(), 4U);  // at 20, 40, 60 and 80 ms; that of 100 ms is under way
  for (int i = 0; i < info.points; ++i) {
    const double angle = 14.25 / 180.0 * M_PI * (i / 639.0 - 0.5);
    EXPECT_NEAR(lines[0].ranges[i], 0.5 / std::cos(angle), 1e-5) << i;
  }
  EXPECT_EQ(lines[0].time, Time(Seconds(0.02)));
  EXPECT_EQ(lines[3].time, Time(Seconds(0.08)));
}

TEST(SimStriper, IsOffByATenthOfAMillimetreAndByItsMounting) {
  NoiseConfig noise = NoiseConfig::None();
  noise.striper_range_sigma = 0.0001;
  const auto simulated = BeforeABoard(0.45, 0.0, noise);
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (const hal::ScanLine& line : Lines(simulated.get(), 0.3)) {
    for (int i = 0; i < 640; ++i) {
      const double error =
          line.ranges[i] - 0.45 / std::cos(14.25 / 180.0 * M_PI * (i / 639.0 - 0.5));
      sum += error;
      squares += error * error;
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 0.0, 5e-6);
  EXPECT_NEAR(std::sqrt(squares / count), 1e-4, 3e-6);

  noise.hand_eye_sigma = 0.001;
  const std::vector<hal::ScanLine> lines = Lines(BeforeABoard(0.45, 0.0, noise).get(), 0.1);
  double mounting = 0.0;
  for (const float range : lines[0].ranges) mounting += range / 640.0;
  EXPECT_GT(std::abs(mounting - 0.45 * 1.0013), 2e-5);
  EXPECT_LT(std::abs(mounting - 0.45 * 1.0013), 4e-3);
}

TEST(SimStriper, SeesNothingTooNearOrTooFarOrTooAslant) {
  const NoiseConfig clean = NoiseConfig::None();
  EXPECT_EQ(Returns(Lines(BeforeABoard(0.29, 0.0, clean).get(), 0.1)), 0);
  EXPECT_GT(Returns(Lines(BeforeABoard(0.31, 0.0, clean).get(), 0.1)), 2500);
  EXPECT_GT(Returns(Lines(BeforeABoard(0.59, 0.0, clean).get(), 0.1)), 2500);
  EXPECT_EQ(Returns(Lines(BeforeABoard(0.61, 0.0, clean).get(), 0.1)), 0);

  NoiseConfig limited = clean;
  limited.striper_max_incidence_deg = 75.0;
  EXPECT_GT(Returns(Lines(BeforeABoard(0.45, 74.0, limited).get(), 0.1)), 2500);
  EXPECT_EQ(Returns(Lines(BeforeABoard(0.45, 75.5, limited).get(), 0.1)), 0);
}

TEST(SimStriper, SeesLittleOfWhatIsDarkAndShiny) {
  NoiseConfig noise = NoiseConfig::None();
  noise.dark_shiny_loss = 0.95;
  geometry::Material mirror;
  mirror.base_color = {0.0F, 0.0F, 0.0F};
  mirror.specular = 1.0F;
  mirror.shininess = 50.0F;
  // Facing it, half of the loss remains; 60 degrees aslant, all of it.
  const int facing = Returns(Lines(BeforeABoard(0.45, 0.0, noise, mirror).get(), 0.1));
  EXPECT_NEAR(facing / 2560.0, 1.0 - 0.95 / 2.0, 0.05);
  const int aslant = Returns(Lines(BeforeABoard(0.45, 60.0, noise, mirror).get(), 0.1));
  EXPECT_NEAR(aslant / 2560.0, 0.05, 0.02);
}

TEST(SimStriper, IsCarriedByTheArm) {
  const auto simulated = BeforeABoard(0.45, 0.0, NoiseConfig::None());
  hal::Arm& arm = *simulated->robot.arm;
  const Eigen::VectorXd q = arm.State().q;
  Eigen::VectorXd goal = q;
  goal[6] += 0.5;  // about the flange's axis: the laser circles, and still faces the board
  goal[5] += 0.05;
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(q.size());
  arm.Start({{{0.0, q, rest}, {2.0, goal, rest}}});
  const ArmDrive& truth = *simulated->world->arm();
  while (arm.Status().phase == hal::MotionPhase::kMoving) simulated->world->Step();
  const std::vector<hal::ScanLine> lines = [&] {
    simulated->robot.striper->On();
    for (int i = 0; i < 5; ++i) simulated->world->Step();
    return simulated->robot.striper->Take();
  }();
  // The board is the plane z = 0.45 m of L as it was.
  const Pose X_LoL = (truth.chain().TipPose(q) * *simulated->X_EL).inverse() *
                     truth.chain().TipPose(goal) * *simulated->X_EL;
  ASSERT_FALSE(lines.empty());
  for (int i = 0; i < 640; ++i) {
    const Eigen::Vector3d p =
        X_LoL * Eigen::Vector3d(lines[0].ranges[i] * simulated->robot.striper->info().Ray(i));
    EXPECT_NEAR(p.z(), 0.45, 2e-5);
  }
}

TEST(SimStriper, MustHoldALine) {
  SimConfig config = Config(NoiseConfig::None());
  config.arm->striper->held = 0;
  EXPECT_THROWS(config.arm->Validate(), ConfigError, "striper.held = 0 must lie in 1..100000");
}

}  // namespace
}  // namespace secondlook::sim
