// The simulated devices keep what the interfaces promise.

#include <gtest/gtest.h>

#include "tests/hal/base_contract.h"
#include "tests/hal/camera_contract.h"
#include "tests/hal/clock_contract.h"
#include "tests/hal/pan_tilt_contract.h"
#include "tests/sim/rig.h"

namespace secondlook {
namespace {

const auto kName = [](const auto& info) { return info.param.name; };

std::shared_ptr<sim::SimulatedRobot> Make(bool noisy) {
  return sim::MakeShared(sim::FreeScene(), noisy ? sim::NoiseConfig{} : sim::NoiseConfig::None(),
                         3);
}

std::vector<ClockFactory> Clocks() {
  return {{"Sim", [] {
             const auto simulated = Make(true);
             return ClockRig{simulated->robot.clock.get(), simulated};
           }}};
}

template <class Factory, class MakeRig>
std::vector<Factory> CleanAndNoisy(MakeRig make_rig) {
  return {{"SimClean", [make_rig] { return make_rig(Make(false)); }},
          {"SimNoisy", [make_rig] { return make_rig(Make(true)); }}};
}

const auto kCameraRig = [](const std::shared_ptr<sim::SimulatedRobot>& s) {
  auto* camera = static_cast<sim::SimCamera*>(s->robot.head_camera.get());
  const auto lose = [camera] { camera->SetFault(sim::CameraFault::kLost); };
  return hal::CameraRig{s->robot.clock.get(), camera, lose, s};
};
const auto kBaseRig = [](const std::shared_ptr<sim::SimulatedRobot>& s) {
  return hal::BaseRig{s->robot.clock.get(), s->robot.base.get(), s};
};
const auto kPanTiltRig = [](const std::shared_ptr<sim::SimulatedRobot>& s) {
  return hal::PanTiltRig{s->robot.clock.get(), s->robot.head.get(), s};
};

}  // namespace

INSTANTIATE_TEST_SUITE_P(Sim, ClockContract, ::testing::ValuesIn(Clocks()), kName);

namespace hal {

INSTANTIATE_TEST_SUITE_P(Sim, CameraContract,
                         ::testing::ValuesIn(CleanAndNoisy<CameraFactory>(kCameraRig)), kName);
INSTANTIATE_TEST_SUITE_P(Sim, BaseContract,
                         ::testing::ValuesIn(CleanAndNoisy<BaseFactory>(kBaseRig)), kName);
INSTANTIATE_TEST_SUITE_P(Sim, PanTiltContract,
                         ::testing::ValuesIn(CleanAndNoisy<PanTiltFactory>(kPanTiltRig)), kName);

}  // namespace hal
}  // namespace secondlook
