#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lib/hal/arm.h"
#include "lib/hal/camera.h"
#include "lib/hal/pan_tilt.h"
#include "lib/kinematics/eye_in_hand.h"
#include "lib/kinematics/inverse_kinematics.h"
#include "lib/planning/motion/plan_motion.h"
#include "lib/world/look.h"

namespace secondlook::planning {

struct ArmViewsConfig {
  double inner_distance_m{0.55};      ///< From the target to the camera …
  double outer_distance_m{0.7};       ///< … on both shells.
  double lowest_elevation_deg{25.0};  ///< Of the camera above the target's horizon …
  double highest_elevation_deg{80.0};
  int elevations{3};  ///< Rings of cameras on each shell, from the lowest to the highest.
  int azimuths{8};    ///< Cameras on each ring, turned by half a step from ring to ring.
  kinematics::InverseKinematicsConfig inverse_kinematics;
  MotionConfig motion;

  template <class A>
  void Serialize(A* a) {
    a->Visit("inner_distance_m", &inner_distance_m);
    a->Visit("outer_distance_m", &outer_distance_m);
    a->Visit("lowest_elevation_deg", &lowest_elevation_deg);
    a->Visit("highest_elevation_deg", &highest_elevation_deg);
    a->Visit("elevations", &elevations);
    a->Visit("azimuths", &azimuths);
    a->Visit("inverse_kinematics", &inverse_kinematics);
    a->Visit("motion", &motion);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// The arm with the camera in its hand, and where it is now.
struct ArmCarrier {
  hal::ArmInfo arm;
  kinematics::EyeInHand hand;
  hal::CameraInfo camera;
  Pose2 X_WB;               ///< Of the base, which stays there.
  hal::PanTiltAngles head;  ///< Of the head, which stays, too.
  Eigen::VectorXd q;        ///< Joint angles [rad].
};

/// The candidates for the next view of a target at `p_WT` that the arm can take from where the base
/// stands: cameras on two shells around it, above its horizon, each looking at it with any roll.
/// Each candidate goes through the checks "range" (of a depth camera), "reach", "inverse
/// kinematics", "collision" and "path", in this order, until one refuses it; none is left out of
/// the result. Of several joint angles for one pose the soonest reached that is free and has a way
/// is taken. `arm_motion` goes there from the carrier's `q`, and `seconds` is what it takes.
/// Deterministic: chance is drawn from `seed` and the candidate.
/// @param collision Of the arm where the base stands.
/// @throws ConfigError when `config` is not valid, InvalidArgument for a target that is not finite.
std::vector<world::Look> ArmViews(const Eigen::Vector3d& p_WT, int target,
                                  const ArmCarrier& carrier, const ArmCollision& collision,
                                  std::uint64_t seed, const ArmViewsConfig& config = {});

}  // namespace secondlook::planning
