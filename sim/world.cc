#include "sim/world.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "lib/common/rng.h"

namespace secondlook::sim {
namespace {

constexpr Duration kKeepStates = Seconds(0.5);
constexpr double kRadians = std::numbers::pi / 180.0;

Pose2 StartPose(const RobotStart& start) {
  return {start.position.x(), start.position.y(), WrapAngle(start.yaw_deg * kRadians)};
}

kinematics::HeadCalibration DrawTrueCalibration(const kinematics::HeadCalibration& nominal,
                                                const NoiseConfig& noise, std::uint64_t seed) {
  Rng rng(ForkSeed(seed, "extrinsics"));
  Eigen::Vector3d shift;
  Eigen::Vector3d turn;
  for (int i = 0; i < 3; ++i) {
    shift[i] = rng.Gaussian(noise.extrinsics_sigma);
    turn[i] = rng.Gaussian(noise.extrinsics_sigma_deg * kRadians);
  }
  kinematics::HeadCalibration truth = nominal;
  truth.X_HC.translation() += shift;
  truth.X_HC.linear() = truth.X_HC.linear() * RotationFromVector(turn);
  return truth;
}

}  // namespace

World::World(const Scene& scene, const NoiseConfig& noise,
             const kinematics::HeadCalibration& nominal, std::uint64_t seed,
             const std::optional<ArmSetup>& arm)
    : scene_(scene),
      noise_(noise),
      objects_(PlaceObjects(scene)),
      fixtures_(MakeFixtures(scene, objects_, BaseDrive::Info().height)),
      true_calibration_(DrawTrueCalibration(nominal, noise, seed)),
      surroundings_{MakeFootprints(fixtures_), {}},
      walkers_(scene.moving_obstacles.begin(), scene.moving_obstacles.end()),
      base_(StartPose(scene.robot), noise, seed),
      head_(noise, seed) {
  for (const Walker& walker : walkers_) surroundings_.moving.push_back(walker.disc());
  if (arm) {
    arm_.emplace(*arm, noise, seed);
    arm_contact_.emplace(fixtures_, arm_->chain());
    if (arm->striper) striper_.emplace(arm->striper->X_EL, arm->striper->held, noise, seed);
  }
  FindCollisions();
  KeepState();
}

void World::Step() {
  const double dt = ToSeconds(kStep);
  now_ += kStep.count();
  const Disc robot = RobotDisc();
  for (std::size_t i = 0; i < walkers_.size(); ++i) {
    walkers_[i].Step(dt, robot);
    surroundings_.moving[i] = walkers_[i].disc();
  }
  base_.Step(dt, surroundings_);
  head_.Step(dt);
  if (arm_) arm_->Step(dt);
  if (striper_) striper_->Step(Now(), ToPose(base_.truth()) * arm_->TrueFlangeInBase());
  FindCollisions();
  KeepState();
}

Disc World::RobotDisc() const {
  return {BaseDrive::Info().name, {base_.truth().x, base_.truth().y}, BaseDrive::Info().radius};
}

void World::FindCollisions() {
  const Disc robot = RobotDisc();
  std::vector<std::string> touching;
  const auto consider = [&](const std::string& name, const Nearest& nearest) {
    if (nearest.distance >= robot.radius) return;
    if (std::find(touching.begin(), touching.end(), name) != touching.end()) return;
    touching.push_back(name);
    if (std::find(touching_.begin(), touching_.end(), name) != touching_.end()) return;
    collisions_.push_back({Now(), name, nearest.point_W, base_.speed(), false});
  };
  for (const Footprint& footprint : surroundings_.fixed) {
    const double far = footprint.bound + robot.radius;
    if ((footprint.center_W - robot.center_W).squaredNorm() >= far * far) continue;
    consider(footprint.name, NearestOf(footprint, robot.center_W, robot.center_W));
  }
  for (const Disc& disc : surroundings_.moving) {
    consider(disc.name, NearestOf(disc, robot.center_W, robot.center_W));
  }
  touching_ = std::move(touching);
  if (arm_ && (arm_->moves() || !base_.stands())) FindArmCollisions();
}

void World::FindArmCollisions() {
  const std::vector<ArmTouch> touches =
      arm_contact_->Touches(ToPose(base_.truth()), arm_->chain().LinkPoses(arm_->encoders()));
  std::vector<std::string> touching;
  for (const ArmTouch& touch : touches) {
    if (std::find(touching.begin(), touching.end(), touch.name) != touching.end()) continue;
    touching.push_back(touch.name);
    if (std::find(arm_touching_.begin(), arm_touching_.end(), touch.name) != arm_touching_.end()) {
      continue;
    }
    collisions_.push_back({Now(), touch.name, touch.point_W.head<2>(), base_.speed(), true});
  }
  arm_touching_ = std::move(touching);
}

void World::KeepState() {
  const hal::PanTiltAngles head = head_.Truth();
  WorldState state{Now(), base_.truth(), {head.pan, head.tilt}, {}, {}, Pose::Identity()};
  for (const Disc& disc : surroundings_.moving) state.obstacles_W.push_back(disc.center_W);
  if (arm_) {
    state.arm = arm_->encoders();
    state.hand_X_BC = arm_->TrueCameraInBase();
  }
  states_.push_back(std::move(state));
  while (states_.front().time < Now() - kKeepStates) states_.pop_front();
}

const WorldState& World::StateAt(Time time) const {
  const auto after = std::upper_bound(states_.begin(), states_.end(), time,
                                      [](Time t, const WorldState& s) { return t < s.time; });
  return after == states_.begin() ? states_.front() : *std::prev(after);
}

Pose World::CameraPose(const WorldState& state) const {
  return ToPose(state.X_WB) * kinematics::CameraInBase(true_calibration_, state.head);
}

Pose World::HandCameraPose(const WorldState& state) const {
  return ToPose(state.X_WB) * state.hand_X_BC;
}

}  // namespace secondlook::sim
