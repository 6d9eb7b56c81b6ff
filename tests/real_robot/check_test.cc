// `secondlook check` on a robot whose devices are emulated, in a network of its own.

#include <sched.h>

#include <cstdlib>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/run_config.h"
#include "lib/common/yaml_reader.h"
#include "lib/kinematics/calibration_file.h"
#include "tests/real_robot/emulated_robot.h"
#include "tests/sim/rig.h"
#include "tests/support/program.h"
#include "tests/support/small_world.h"

namespace secondlook::apps {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::RunProgram;

/// Puts this process and those it starts into a network of their own, once. False where that is not
/// allowed.
bool HasOwnNetwork() {
  static const bool own = unshare(CLONE_NEWNET) == 0 &&
                          std::system("ip link set lo up && ip route add 224.0.0.0/4 dev lo") == 0;
  return own;
}

class CheckRealRobot : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!HasOwnNetwork()) GTEST_SKIP() << "a network of its own needs root, and iproute2";
    link_ = std::make_shared<hal::LcmLink>(transport::kDefaultLcmUrl);
    robot_ = std::make_unique<EmulatedRobot>(
        sim::MakeSimulatedRobot(sim::LoadScene(world_ / "scene.yaml"), sim::SimConfig{}, 1), link_,
        world_ / "", 0.1);
    kinematics::SaveCalibration({robot_->calibration(), {}, {}}, world_ / "calibration.yaml");
    RunConfig config;
    RealConfig real = robot_->Config(transport::kDefaultLcmUrl);
    real.calibration = (world_ / "calibration.yaml").string();
    config.robot = real;
    config.models = world_.models().string();
    SaveRunConfig(config, world_.config());
  }

  ProgramResult Check(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"check", "--config", world_.config().string()};
    for (const std::string& set : more) arguments.insert(arguments.end(), {"--set", set});
    return RunProgram(arguments);
  }

  testing::SmallWorld world_;
  std::shared_ptr<hal::LcmLink> link_;
  std::unique_ptr<EmulatedRobot> robot_;
};

TEST_F(CheckRealRobot, TellsOfEachDeviceWhatItIsLike) {
  const ProgramResult result = Check();
  EXPECT_EQ(result.status, 0) << result.out;
  EXPECT_THAT(result.out, HasSubstr("nobody has calibrated it: `secondlook calibrate` does"));
  EXPECT_THAT(result.out, ContainsRegex("ok +camera +'head': 640 x 480 pixels, 58 x 45 deg, depth "
                                        "from 0.5 to 6 m; fx 577.*px"));
  EXPECT_THAT(result.out, ContainsRegex("ok +rate +'head': [0-9]+ frames a second, the newest 0"));
  EXPECT_THAT(result.out, ContainsRegex("ok +pan-tilt +'pan-tilt unit at .*limits: pan -159 to "
                                        "159 deg, tilt -31 to 47 deg"));
  EXPECT_THAT(result.out, ContainsRegex("ok +base +'base': at "));
}

TEST_F(CheckRealRobot, GoesOnAfterADeviceThatDoesNotAnswer) {
  robot_->SetCameraSilent(true);
  const ProgramResult result =
      Check({"robot.camera.patience_seconds=0.3", "robot.pan_tilt.device=/dev/ttyNone"});
  EXPECT_EQ(result.status, 3) << result.out;
  EXPECT_THAT(result.out, ContainsRegex("WRONG +camera +camera 'head': nothing came on channel"));
  EXPECT_THAT(result.out, ContainsRegex("WRONG +pan-tilt +/dev/ttyNone: cannot be opened"));
  EXPECT_THAT(result.out, ContainsRegex("ok +base +'base': at "));
}

TEST_F(CheckRealRobot, HoldsTheConfigurationToWhatIsRight) {
  const auto refuses = [&](const std::string& set, const std::string& why) {
    const ProgramResult result = Check({set});
    EXPECT_EQ(result.status, 2);
    EXPECT_THAT(result.out, HasSubstr(why));
  };
  refuses("robot.calibration=none.yaml", "none.yaml");
  refuses("robot.lcm_url=udpm://239.255.76.67:7667?ttl=1",
          "reaches beyond this host, where everybody could then command the base");
  refuses("robot.camera.intrinsics=[500]", "'intrinsics' has 1 values");
  refuses("robot.base.speed=50", "'speed' = 50 must lie in 0.01..5");
}

}  // namespace
}  // namespace secondlook::apps
