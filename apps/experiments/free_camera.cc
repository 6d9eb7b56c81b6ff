#include "apps/experiments/free_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/core.hpp>

#include "sim/fixtures.h"
#include "sim/noise.h"

namespace secondlook::apps {
namespace {

/// Twice as wide and high around the same optical axis, in as many pixels: each is four of `model`.
geometry::CameraModel Widened(geometry::CameraModel model) {
  model.cx += model.width / 2.0;
  model.cy += model.height / 2.0;
  model.width *= 2;
  model.height *= 2;
  return model.Scaled(0.5);
}

}  // namespace

Pose DrawView(const Eigen::Vector3d& target_W, Rng* rng) {
  const double azimuth = rng->Uniform(-std::numbers::pi, std::numbers::pi);
  const double elevation = rng->Uniform(20.0, 70.0) * std::numbers::pi / 180.0;
  const double distance = rng->Uniform(0.6, 1.2);
  const Eigen::Vector3d towards(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  return LookAt(target_W + distance * towards, target_W);
}

FreeCamera::FreeCamera(const sim::Scene& scene, std::uint64_t seed)
    : robot_(sim::MakeSimulatedRobot(scene, {}, seed)),
      info_(robot_.robot.head_camera->info()),
      renderer_(*robot_.world, info_.model),
      wide_renderer_(*robot_.world, Widened(info_.model)),
      rng_(ForkSeed(seed, "free camera")) {}

Photo FreeCamera::Take(const Pose& X_WC) {
  const sim::World& world = *robot_.world;
  const sim::Render clean = renderer_.Draw(X_WC, world.StateAt(world.Now()));
  Photo photo;
  photo.X_WC = X_WC;
  photo.id = clean.id;
  photo.clean_depth = clean.depth;
  photo.frame.sequence = ++taken_;
  photo.frame.depth =
      sim::DepthNoise(clean, info_.model, {info_.min_depth, info_.max_depth}, world.noise(), &rng_);
  photo.frame.color = sim::ColorNoise(clean, world.noise(), &rng_);
  return photo;
}

std::vector<double> FreeCamera::VisibleShares(const Photo& photo) {
  const cv::Mat measured =
      (photo.clean_depth >= info_.min_depth) & (photo.clean_depth <= info_.max_depth);
  std::vector<double> shares;
  for (int i = 0; i < static_cast<int>(world().objects().size()); ++i) {
    const int whole = 4 * cv::countNonZero(wide_renderer_.DrawAlone(photo.X_WC, i).id);
    const int visible = cv::countNonZero((photo.id == sim::kFirstObjectId + i) & measured);
    shares.push_back(whole > 0 ? std::min(1.0, static_cast<double>(visible) / whole) : 0.0);
  }
  return shares;
}

}  // namespace secondlook::apps
