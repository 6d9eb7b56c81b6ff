// The simulated devices keep what the interfaces promise, tapped and guarded ones too.

#include <gtest/gtest.h>

#include "lib/hal/guard.h"
#include "lib/hal/tap.h"
#include "lib/kinematics/box_of_moved.h"
#include "sim/sim_striper.h"
#include "tests/hal/arm_contract.h"
#include "tests/hal/base_contract.h"
#include "tests/hal/camera_contract.h"
#include "tests/hal/clock_contract.h"
#include "tests/hal/laser_striper_contract.h"
#include "tests/hal/pan_tilt_contract.h"
#include "tests/sim/rig.h"

namespace secondlook {
namespace {

const auto kName = [](const auto& info) { return info.param.name; };

constexpr int kHeld = 10;  // lines

/// A robot with all that there is, something before its laser.
std::shared_ptr<sim::SimulatedRobot> Make(bool noisy) {
  sim::SimConfig config;
  config.noise = noisy ? sim::NoiseConfig{} : sim::NoiseConfig::None();
  config.arm.emplace().urdf = "sim/robots/arm.urdf";
  config.arm->striper.emplace().held = kHeld;
  sim::Scene scene = sim::FreeScene();
  const sim::ArmSetup arm = sim::LoadArm(*config.arm);
  const Pose X_WL = ToPose(Pose2{0.0, 0.0, 20.0 / 180.0 * M_PI}) * arm.hand.arm.TipPose(arm.home) *
                    arm.striper->X_EL;
  sim::SceneBox target;
  target.size = {0.1, 0.1, 0.1};
  target.position = X_WL * Eigen::Vector3d(0.0, 0.0, 0.45);
  scene.boxes.push_back(target);
  return sim::MakeShared(scene, config, 3);
}

/// A simulated robot with an arm, its cameras and its laser as they were before anything was
/// tapped.
struct Simulated {
  std::shared_ptr<sim::SimulatedRobot> owner;
  sim::SimCamera* camera;
  sim::SimCamera* hand_camera;
  sim::SimStriper* striper;
  hal::Robot& robot;

  explicit Simulated(std::shared_ptr<sim::SimulatedRobot> simulated)
      : owner(std::move(simulated)),
        camera(static_cast<sim::SimCamera*>(owner->robot.head_camera.get())),
        hand_camera(static_cast<sim::SimCamera*>(owner->robot.hand_camera.get())),
        striper(static_cast<sim::SimStriper*>(owner->robot.striper.get())),
        robot(owner->robot) {}
};

Simulated MakeTapped() {
  static hal::RobotListener nobody;
  Simulated simulated(Make(true));
  simulated.robot = hal::Tap(std::move(simulated.robot), &nobody);
  return simulated;
}

/// Behind a guard with every limit, which lives with the robot.
Simulated MakeGuarded() {
  struct Guarded {
    hal::Guard guard;
    std::shared_ptr<sim::SimulatedRobot> simulated;
  };
  hal::GuardConfig config;
  config.base_speed = 1.0;
  config.base_turn_rate_deg = 180.0;
  config.head_speed_deg = 180.0;
  config.arm_speed_deg = 360.0;
  config.workspace.emplace();
  config.arm_workspace.emplace();
  const std::shared_ptr<Guarded> guarded(new Guarded{hal::Guard(config), Make(true)});
  Simulated simulated({guarded, guarded->simulated.get()});
  simulated.robot = guarded->guard.Protect(
      std::move(simulated.robot), [&arm = guarded->simulated->hand->arm](const Eigen::VectorXd& q) {
        return kinematics::BoxOfMoved(arm, q);
      });
  return simulated;
}

const auto kClockRig = [](const Simulated& s) { return ClockRig{s.robot.clock.get(), s.owner}; };

std::vector<ClockFactory> Clocks() {
  return {{"Sim", [] { return kClockRig(Simulated(Make(true))); }},
          {"Tapped", [] { return kClockRig(MakeTapped()); }}};
}

template <class Factory, class MakeRig>
std::vector<Factory> EachKind(MakeRig make_rig) {
  return {{"SimClean", [make_rig] { return make_rig(Simulated(Make(false))); }},
          {"SimNoisy", [make_rig] { return make_rig(Simulated(Make(true))); }},
          {"Tapped", [make_rig] { return make_rig(MakeTapped()); }},
          {"Guarded", [make_rig] { return make_rig(MakeGuarded()); }}};
}

const auto kCameraRig = [](const Simulated& s) {
  const auto lose = [camera = s.camera] { camera->SetFault(sim::CameraFault::kLost); };
  return hal::CameraRig{s.robot.clock.get(), s.robot.head_camera.get(), lose, false, s.owner};
};
const auto kHandCameraRig = [](const Simulated& s) {
  const auto lose = [camera = s.hand_camera] { camera->SetFault(sim::CameraFault::kLost); };
  return hal::CameraRig{s.robot.clock.get(), s.robot.hand_camera.get(), lose, false, s.owner};
};
const auto kArmRig = [](const Simulated& s) {
  return hal::ArmRig{s.robot.clock.get(), s.robot.arm.get(), s.owner};
};
const auto kStriperRig = [](const Simulated& s) {
  return hal::StriperRig{s.robot.clock.get(),
                         s.robot.striper.get(),
                         [world = s.owner->world.get()] { return world->striper()->lit(); },
                         kHeld,
                         [striper = s.striper] { striper->Lose(); },
                         s.owner};
};
const auto kBaseRig = [](const Simulated& s) {
  return hal::BaseRig{s.robot.clock.get(), s.robot.base.get(), s.owner};
};
const auto kPanTiltRig = [](const Simulated& s) {
  return hal::PanTiltRig{s.robot.clock.get(), s.robot.head.get(), s.owner};
};

}  // namespace

INSTANTIATE_TEST_SUITE_P(Sim, ClockContract, ::testing::ValuesIn(Clocks()), kName);

namespace hal {

INSTANTIATE_TEST_SUITE_P(Sim, CameraContract,
                         ::testing::ValuesIn(EachKind<CameraFactory>(kCameraRig)), kName);
INSTANTIATE_TEST_SUITE_P(SimHand, CameraContract,
                         ::testing::ValuesIn(EachKind<CameraFactory>(kHandCameraRig)), kName);
INSTANTIATE_TEST_SUITE_P(Sim, ArmContract, ::testing::ValuesIn(EachKind<ArmFactory>(kArmRig)),
                         kName);
INSTANTIATE_TEST_SUITE_P(Sim, BaseContract, ::testing::ValuesIn(EachKind<BaseFactory>(kBaseRig)),
                         kName);
INSTANTIATE_TEST_SUITE_P(Sim, LaserStriperContract,
                         ::testing::ValuesIn(EachKind<StriperFactory>(kStriperRig)), kName);
INSTANTIATE_TEST_SUITE_P(Sim, PanTiltContract,
                         ::testing::ValuesIn(EachKind<PanTiltFactory>(kPanTiltRig)), kName);

}  // namespace hal
}  // namespace secondlook
