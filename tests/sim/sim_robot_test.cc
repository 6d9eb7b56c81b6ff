#include "sim/sim_robot.h"

#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "lib/common/hash.h"
#include "lib/common/yaml_reader.h"
#include "sim/ground_truth.h"
#include "tests/sim/rig.h"
#include "tests/support/expect_throws.h"

namespace secondlook::sim {
namespace {

constexpr const char* kScene = "sim/scenes/default.yaml";

std::string_view Bytes(const cv::Mat& mat) {
  return {reinterpret_cast<const char*>(mat.data), mat.total() * mat.elemSize()};
}

template <class T>
std::string_view Bytes(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof(T)};
}

/// A short life of a robot: it drives, looks around and grabs.
class Life {
 public:
  explicit Life(std::uint64_t seed)
      : simulated_(MakeSimulatedRobot(LoadScene(kScene), SimConfig{}, seed)) {}

  /// One of its days; what was seen and measured goes into the hash.
  void Live(int day) {
    const hal::BaseState start = simulated_.robot.base->State();
    simulated_.robot.base->Start(
        {{{start.X_WB.x + 0.1 * (day % 2), start.X_WB.y - 0.2, 0.3 * day}}});
    simulated_.robot.head->Start({0.1 * day, 0.45});
    for (int i = 0; i < 40; ++i) {
      simulated_.robot.clock->SleepUntil(simulated_.robot.clock->Now() + Seconds(0.1));
      const Pose2 X_WB = simulated_.robot.base->State().X_WB;
      const Pose2 X_OB = simulated_.robot.base->State().X_OB;
      for (const double value : {X_WB.x, X_WB.y, X_WB.yaw, X_OB.x, X_OB.y, X_OB.yaw,
                                 simulated_.robot.head->State().angles.pan}) {
        hash_ = Fnv1a(Bytes(value), hash_);
      }
    }
    const hal::RgbdFrame frame = simulated_.robot.head_camera->Grab(Seconds(1)).value();
    hash_ = Fnv1a(Bytes(frame.color), hash_);
    hash_ = Fnv1a(Bytes(frame.depth), hash_);
    hash_ = Fnv1a(static_cast<std::uint64_t>(frame.time.time_since_epoch().count()), hash_);
  }

  std::uint64_t hash() const { return hash_; }

 private:
  SimulatedRobot simulated_;
  std::uint64_t hash_{Fnv1a("")};
};

TEST(SimulatedRobot, TheSameSeedGivesTheSameBytes) {
  Life a(7);
  Life b(7);
  Life c(8);
  for (Life* life : {&a, &b, &c}) {
    for (int day = 0; day < 3; ++day) life->Live(day);
  }
  EXPECT_EQ(a.hash(), b.hash());
  EXPECT_NE(a.hash(), c.hash());
}

TEST(SimulatedRobot, TwoWorldsSideBySideLiveAsEachAlone) {
  Life alone_a(7);
  for (int day = 0; day < 3; ++day) alone_a.Live(day);
  Life alone_b(9);
  for (int day = 0; day < 3; ++day) alone_b.Live(day);
  Life a(7);
  Life b(9);
  for (int day = 0; day < 3; ++day) {
    b.Live(day);
    a.Live(day);
  }
  EXPECT_EQ(a.hash(), alone_a.hash());
  EXPECT_EQ(b.hash(), alone_b.hash());
}

TEST(SimulatedRobot, AFrameShowsWhatIsWhereTheTruthSays) {
  // Without errors, each measured point that shows an object lies within that object's box in M.
  SimConfig config;
  config.noise = NoiseConfig::None();
  SimulatedRobot s = MakeSimulatedRobot(LoadScene(kScene), config, 1);
  s.robot.head->Start({0.0, 0.45});
  WaitForHead(&s);
  s.world->Step();
  s.robot.clock->SleepUntil(s.world->Now() + Seconds(0.1));
  const hal::RgbdFrame frame = s.robot.head_camera->Grab(Seconds(1)).value();
  const hal::CameraModel model = s.robot.head_camera->info().model;
  GroundTruth truth(*s.world);
  const Pose X_CW = truth.ViewOf(frame.sequence).X_WC.inverse();
  const cv::Mat ids = truth.CleanFrame(frame.sequence, model).id;
  // The nominal chain gives the same pose when nothing errs.
  const hal::PanTiltAngles angles = s.robot.head->State().angles;
  const Pose X_WC = ToPose(s.robot.base->State().X_WB) *
                    kinematics::CameraInBase(s.calibration, {angles.pan, angles.tilt});
  EXPECT_TRUE((X_CW * X_WC).isApprox(Pose::Identity(), 1e-9));
  std::vector<Eigen::AlignedBox3d> bounds;
  for (const PlacedObject& object : truth.objects()) bounds.push_back(Bounds(object.mesh));
  int checked = 0;
  for (int v = 0; v < model.height; ++v) {
    for (int u = 0; u < model.width; ++u) {
      const int index = ids.at<std::uint16_t>(v, u) - kFirstObjectId;
      if (index < 0 || index >= static_cast<int>(truth.objects().size())) continue;
      const PlacedObject& object = truth.objects()[index];
      const Eigen::Vector3d p_CQ = model.Ray(u, v) * frame.depth.at<float>(v, u);
      const Eigen::Vector3d p_MQ = object.X_WM.inverse() * X_CW.inverse() * p_CQ;
      EXPECT_LT(bounds[index].exteriorDistance(p_MQ), 1e-4) << object.name;
      ++checked;
    }
  }
  EXPECT_GT(checked, 1000);
}

TEST(SimulatedRobot, StampsErrBySigmaAndAreNeverAheadOfThePresent) {
  const auto s = MakeShared(FreeScene(), NoiseConfig{}, 1);
  double squares = 0.0;
  for (int i = 0; i < 60; ++i) {
    const hal::RgbdFrame frame = s->robot.head_camera->Grab(Seconds(1)).value();
    const TrueView& view = s->world->views().back();
    EXPECT_EQ(view.sequence, frame.sequence);
    EXPECT_LE(frame.time, s->world->Now());
    squares += std::pow(ToSeconds(frame.time - view.state.time), 2);
  }
  EXPECT_NEAR(std::sqrt(squares / 60), 0.005, 0.0015);
}

TEST(SimulatedRobot, NothingIsRenderedThatNobodyGrabs) {
  const auto s = MakeShared(FreeScene(), NoiseConfig{}, 1);
  s->robot.clock->SleepUntil(Time(Seconds(20)));
  EXPECT_TRUE(s->world->views().empty());
}

TEST(SimulatedRobot, ABrokenCameraDeliversNanOrNothing) {
  SimConfig config;
  config.camera_fault = "nan";
  SimulatedRobot blind = MakeSimulatedRobot(FreeScene(), config, 1);
  const hal::RgbdFrame frame = blind.robot.head_camera->Grab(Seconds(1)).value();
  for (int v = 0; v < frame.depth.rows; ++v) {
    for (int u = 0; u < frame.depth.cols; ++u) ASSERT_TRUE(std::isnan(frame.depth.at<float>(v, u)));
  }
  config.camera_fault = "nothing";
  SimulatedRobot silent = MakeSimulatedRobot(FreeScene(), config, 1);
  EXPECT_FALSE(silent.robot.head_camera->Grab(Seconds(1)).has_value());
  EXPECT_EQ(silent.world->Now(), Time(Seconds(1)));
  config.camera_fault = "lost";
  SimulatedRobot lost = MakeSimulatedRobot(FreeScene(), config, 1);
  EXPECT_THROWS(lost.robot.head_camera->Grab(Seconds(1)), DeviceError,
                "camera 'head': the device is lost");
}

TEST(SimConfig, ReadsItsKeysAndNamesAWrongFault) {
  SimConfig config;
  ApplyLayer({YAML::Load("{scene: a.yaml, noise: {color_sigma: 1}, camera_fault: nan}"), "r.yaml"},
             &config);
  EXPECT_EQ(config.scene, "a.yaml");
  EXPECT_EQ(config.noise.color_sigma, 1.0);
  EXPECT_EQ(config.camera_fault, "nan");
  EXPECT_THROWS(ApplyLayer({YAML::Load("{camera_fault: dust}"), "r.yaml"}, &config), ConfigError,
                "r.yaml:1:1: 'camera_fault' = 'dust' must be none, nan, nothing or lost");
}

TEST(SimulatedRobot, TheNoiseOfTheSceneGoesOverThatOfTheConfiguration) {
  Scene scene = FreeScene();
  scene.noise = "{color_sigma: 9}";
  SimConfig config;
  config.noise.color_sigma = 1.0;
  config.noise.stamp_sigma = 0.001;
  const SimulatedRobot s = MakeSimulatedRobot(scene, config, 1);
  EXPECT_EQ(s.world->noise().color_sigma, 9.0);
  EXPECT_EQ(s.world->noise().stamp_sigma, 0.001);
}

TEST(GroundTruth, CountsVisibleAndUnoccludedPixels) {
  SimulatedRobot s = MakeSimulatedRobot(LoadScene(kScene), SimConfig{}, 1);
  s.robot.head->Start({0.0, 0.45});
  WaitForHead(&s);
  s.robot.clock->SleepUntil(s.world->Now() + Seconds(0.1));
  const hal::RgbdFrame frame = s.robot.head_camera->Grab(Seconds(1)).value();
  GroundTruth truth(*s.world);
  const std::vector<Visibility> seen =
      truth.VisibilityIn(frame.sequence, s.robot.head_camera->info().model);
  ASSERT_EQ(seen.size(), 7U);
  bool one_is_occluded = false;
  for (const Visibility& v : seen) {
    EXPECT_GT(v.unoccluded_pixels, 100);
    EXPECT_LE(v.visible_pixels, v.unoccluded_pixels);
    one_is_occluded = one_is_occluded || v.visible_pixels < 0.7 * v.unoccluded_pixels;
  }
  EXPECT_TRUE(one_is_occluded);
  EXPECT_THROWS(truth.ViewOf(99999), InvalidArgument, "frame 99999 was never grabbed");
}

}  // namespace
}  // namespace secondlook::sim
