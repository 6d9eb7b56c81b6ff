#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/hal/arm.h"
#include "lib/hal/base.h"
#include "lib/hal/camera.h"
#include "lib/hal/pan_tilt.h"
#include "lib/kinematics/eye_in_hand.h"
#include "lib/planning/arm_views.h"
#include "lib/planning/motion/arm_collision.h"
#include "lib/planning/motion/arm_way.h"
#include "lib/planning/motion/obstacles.h"
#include "lib/world/look.h"
#include "lib/world/support_plane.h"
#include "lib/world/voxel_space.h"

namespace secondlook::apps {

/// How looks by the arm are planned.
struct ArmLooksConfig {
  planning::ArmViewsConfig views;
  planning::ObstacleConfig obstacles;
  planning::ArmCollisionConfig collision;

  template <class A>
  void Serialize(A* a) {
    a->Visit("views", &views);
    a->Visit("obstacles", &obstacles);
    a->Visit("collision", &collision);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// Where the robot stands, as it believes.
struct Stance {
  Pose2 X_WB;
  hal::PanTiltAngles head;
  Eigen::VectorXd q{};  ///< Of the arm [rad]; empty without one.
  Time time{};
};

/// An arm with a camera in its hand.
struct HandDevices {
  hal::BaseInfo base;  ///< That it stands on.
  hal::ArmInfo arm;
  hal::CameraInfo camera;
  kinematics::EyeInHand hand;
};

/// The looks that an arm can take from where the robot stands, and how it is folded again before
/// the base drives: it goes back the way it came.
class ArmLooks {
 public:
  /// @param q Where the arm is folded [rad].
  /// @param seed Of all chance in its motions.
  /// @throws ConfigError when `config` is not valid, or the arm at `q` is not within the cylinder
  /// that the base drives as.
  ArmLooks(const ArmLooksConfig& config, HandDevices devices, const Eigen::VectorXd& q,
           std::uint64_t seed);

  const hal::CameraInfo& camera() const { return devices_.camera; }

  /// The arm and all in its hand are not to leave `box_B`.
  /// @throws ConfigError when it is not within where it is folded, with collision.clearance_m to
  /// spare.
  void KeepWithin(const Eigen::AlignedBox3d& box_B);

  /// It has set out along `motion` and stands at `q`: at its end, or where it was stopped.
  void Follow(const hal::JointTrajectory& motion, const Eigen::VectorXd& q) {
    way_.Follow(motion, q);
  }

  /// The motion that folds it, from `q` where it stands; empty when it is folded.
  hal::JointTrajectory Folding(const Eigen::VectorXd& q) const;

  /// What is in its way from there. Where the robot stands with the arm folded nothing is unknown:
  /// it is there itself, or has been, driving. All else has to be seen before the arm goes there.
  planning::ArmCollision CollisionAt(const Stance& stance, const world::VoxelSpace& space,
                                     const std::vector<world::SupportPlane>& supports_W) const;

  /// The candidates (planning::ArmViews) for a target at `p_WT`.
  std::vector<world::Look> Views(const Eigen::Vector3d& p_WT, int target, const Stance& stance,
                                 const planning::ArmCollision& collision);

 private:
  ArmLooksConfig config_;
  HandDevices devices_;
  planning::ArmWay way_;
  std::optional<Eigen::AlignedBox3d> workspace_B_;
  std::uint64_t seed_;
  int planned_{};  // targets that views were planned for
};

}  // namespace secondlook::apps
