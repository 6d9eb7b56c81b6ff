#pragma once

#include <numbers>
#include <utility>

#include "lib/common/pose.h"
#include "lib/common/rng.h"
#include "sim/scene.h"

namespace secondlook::apps {

/// One object on a pedestal.
inline sim::Scene OnPedestal(sim::SceneObject object) {
  sim::Scene scene;
  scene.name = "pedestal";
  scene.table.size = {0.5, 0.5};
  scene.table.solid = true;
  scene.walls.emplace();
  object.position = {0.0, 0.0};
  scene.objects.push_back(std::move(object));
  return scene;
}

/// A small motion, normal in every axis: `sigma` [m], `sigma_deg` [deg].
inline Pose SmallMotion(double sigma, double sigma_deg, Rng* rng) {
  const auto draw = [&](double s) {
    return Eigen::Vector3d(rng->Gaussian(s), rng->Gaussian(s), rng->Gaussian(s));
  };
  Pose X = Pose::Identity();
  X.linear() = RotationFromVector(draw(sigma_deg * std::numbers::pi / 180.0));
  X.translation() = draw(sigma);
  return X;
}

}  // namespace secondlook::apps
