#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/kinematics/chain.h"

namespace secondlook::kinematics {

/// The smallest box along the axes of B around the bodies of all links that the joints of `chain`
/// move, and the origins of their frames, at the joint angles `q` [rad].
/// @pre q has a value for each joint.
Eigen::AlignedBox3d BoxOfMoved(const Chain& chain, const Eigen::VectorXd& q);

}  // namespace secondlook::kinematics
