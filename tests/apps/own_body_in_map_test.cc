#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "apps/capture.h"
#include "lib/world/voxel_space.h"
#include "sim/scene.h"
#include "sim/sim_robot.h"

namespace secondlook::apps {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// The occupied voxels that a view of the robot's outstretched arm leaves near the arm, with all
/// its noise.
class ViewOfTheArm {
 public:
  explicit ViewOfTheArm(bool know_the_arm) {
    sim::Scene scene;
    scene.table.position = {3.0, 2.0};
    scene.floor.size = {10.0, 8.0};
    scene.robot = {{0.0, 0.0}, 0.0};
    sim::SimConfig config;
    config.arm.emplace().urdf = "sim/robots/arm.urdf";
    simulated_ = sim::MakeSimulatedRobot(scene, config, 4);
    hal::Robot& robot = simulated_.robot;
    // So low and far ahead that the camera is 0.5 m and more from it.
    Eigen::VectorXd q = robot.arm->State().q;
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(q.size());
    Eigen::VectorXd ahead = rest;
    ahead[1] = 100.0 * kDegree;
    robot.arm->Start({{{0.0, q, rest}, {8.0, ahead, rest}}});
    robot.head->Start({0.0, 0.8});
    while (robot.arm->Status().phase == hal::MotionPhase::kMoving) simulated_.world->Step();

    Capturer capturer(&robot, simulated_.calibration);
    if (know_the_arm) capturer.KnowArm(*simulated_.hand);
    const Capture capture = capturer.Take(Seconds(1)).value();
    world::VoxelSpace space;
    space.Insert(capture.frame.depth, capture.camera, capture.X_WC, 1);
    const Pose X_WB = capture.X_WC * CameraInBase(simulated_.calibration, {0.0, 0.8}).inverse();
    const auto body_B = simulated_.hand->arm.Body(robot.arm->State().q);
    Count(space, X_WB, body_B);
  }

  int near_the_body{};
  int elsewhere{};

 private:
  void Count(const world::VoxelSpace& space, const Pose& X_WB,
             const std::vector<geometry::PlacedShape>& body_B) {
    const Pose X_BW = X_WB.inverse();
    const world::BrickGrid& grid = space.surroundings();
    for (double x = -1.0; x < 2.5; x += grid.voxel()) {
      for (double y = -1.0; y < 1.0; y += grid.voxel()) {
        for (double z = -0.1; z < 1.5; z += grid.voxel()) {
          const Eigen::Vector3d p_WQ(x, y, z);
          if (space.At(p_WQ) != world::Occupancy::kOccupied) continue;
          double distance = std::numeric_limits<double>::infinity();
          for (const auto& part : body_B) {
            const Eigen::Vector3d p_SQ = part.X_AS.inverse() * (X_BW * p_WQ);
            distance = std::min(distance, geometry::Distance(part.shape, p_SQ));
          }
          ++(distance < 0.1 ? near_the_body : elsewhere);
        }
      }
    }
  }

  sim::SimulatedRobot simulated_;
};

TEST(OwnBody, LeavesNoVoxelInTheMap) {
  const ViewOfTheArm unaware(false);
  EXPECT_GT(unaware.near_the_body, 100) << "the arm is in view";
  const ViewOfTheArm aware(true);
  EXPECT_EQ(aware.near_the_body, 0);
  // The floor is there as before, but for the shadow of the arm.
  EXPECT_GT(aware.elsewhere, 1000);
}

}  // namespace
}  // namespace secondlook::apps
