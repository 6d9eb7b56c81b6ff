#pragma once

#include "apps/arm_looks.h"
#include "apps/capture.h"
#include "apps/experiments/free_camera.h"
#include "lib/common/rng.h"
#include "lib/planning/views.h"

namespace secondlook::apps {

/// What a robot sees, and the truth of it.
struct Sight {
  Capture capture;
  Photo photo;
};

/// What carries the camera of the simulated robot.
planning::CameraCarrier CarrierOf(const FreeCamera& camera);

/// Where a base truly stands that believes to stand at `X_WB`.
Pose2 DrawTruth(const Pose2& X_WB, const sim::NoiseConfig& noise, Rng* rng);

/// What the robot sees when it believes to stand at `stance`: put there rather than driven, with
/// all the errors of one that drove, which are drawn from `rng`.
Sight LookFrom(const Stance& stance, Rng* rng, FreeCamera* camera);

}  // namespace secondlook::apps
