#include "apps/experiments/sight.h"

#include <numbers>

namespace secondlook::apps {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace

planning::CameraCarrier CarrierOf(const FreeCamera& camera) {
  const hal::Robot& robot = camera.robot().robot;
  return {robot.base->info(), robot.head->info(), camera.robot().calibration, camera.info()};
}

Pose2 DrawTruth(const Pose2& X_WB, const sim::NoiseConfig& noise, Rng* rng) {
  Pose2 truth;
  truth.x = X_WB.x + rng->Gaussian(noise.localisation_sigma);
  truth.y = X_WB.y + rng->Gaussian(noise.localisation_sigma);
  truth.yaw = WrapAngle(X_WB.yaw + rng->Gaussian(noise.localisation_sigma_deg * kDegree));
  return truth;
}

Sight LookFrom(const Stance& stance, Rng* rng, FreeCamera* camera) {
  const sim::World& world = camera->world();
  const sim::NoiseConfig& noise = world.noise();
  sim::WorldState truth;
  truth.X_WB = DrawTruth(stance.X_WB, noise, rng);
  truth.head.pan = stance.head.pan + rng->Gaussian(noise.pan_tilt_sigma_deg * kDegree);
  truth.head.tilt = stance.head.tilt + rng->Gaussian(noise.pan_tilt_sigma_deg * kDegree);
  Sight sight;
  sight.photo = camera->Take(world.CameraPose(truth), rng);
  const Pose X_WB = ToPose(stance.X_WB);
  sight.capture.frame = sight.photo.frame;
  sight.capture.camera = camera->info().model;
  sight.capture.X_WC = X_WB * kinematics::CameraInBase(camera->robot().calibration,
                                                       {stance.head.pan, stance.head.tilt});
  sight.capture.p_CB_W = X_WB.translation() - sight.capture.X_WC.translation();
  return sight;
}

}  // namespace secondlook::apps
