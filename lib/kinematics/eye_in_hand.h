#pragma once

#include "lib/common/pose.h"
#include "lib/kinematics/chain.h"

namespace secondlook::kinematics {

/// An arm and the camera C at its end-effector E, from description and calibration.
struct EyeInHand {
  Chain arm;
  Pose X_EC{Pose::Identity()};  ///< Hand–eye calibration: x right, y down, z out of the lens.
};

/// X_BC at the joint angles `q` [rad].
inline Pose CameraInBase(const EyeInHand& hand, const Eigen::VectorXd& q) {
  return hand.arm.TipPose(q) * hand.X_EC;
}

}  // namespace secondlook::kinematics
