#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/kinematics/chain.h"

namespace secondlook::kinematics {

struct InverseKinematicsConfig {
  int starts{32};             ///< Joint angles that the search begins from, one after the other.
  int iterations{120};        ///< From each of them, at most.
  int solutions{4};           ///< Enough of them; the search ends.
  double position_m{1e-5};    ///< How exact a solution is, at most 1e-4 …
  double rotation_deg{1e-3};  ///< … and at most 1e-2.
  double apart_deg{5.0};      ///< Solutions differ by at least so much in some joint.

  template <class A>
  void Serialize(A* a) {
    a->Visit("starts", &starts);
    a->Visit("iterations", &iterations);
    a->Visit("solutions", &solutions);
    a->Visit("position_m", &position_m);
    a->Visit("rotation_deg", &rotation_deg);
    a->Visit("apart_deg", &apart_deg);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A frame C that is fixed to the end-effector, and where it is to be.
struct ToolGoal {
  Pose X_BC{Pose::Identity()};
  Pose X_EC{Pose::Identity()};
  bool free_roll{};  ///< It may be turned about its z axis, e.g. the optical axis of a camera.
};

/// How a goal can be met.
struct JointSolutions {
  std::vector<Eigen::VectorXd> q;  ///< Within the limits, that soonest reached first; may be empty.
  double position_error{};  ///< Of the nearest that was found [m], 0 when there is a solution.
  double rotation_error{};  ///< Of the same [rad].
  std::string reason;       ///< Why there is none: "unreachable: the nearest is 0.040 m …".
};

/// Joint angles that bring C to its goal: damped least squares (Levenberg, Marquardt) with joints
/// held at their limits, from `near` [rad], from the middle of all ranges, and from a fixed set of
/// random angles. Deterministic. Exact or not there: what does not meet position_m and rotation_deg
/// is no solution.
/// @throws ConfigError when `config` is not valid, InvalidArgument for a goal that is no rigid
/// transform or a `near` of the wrong size or not finite.
JointSolutions SolveInverseKinematics(const Chain& chain, const ToolGoal& goal,
                                      const Eigen::VectorXd& near,
                                      const InverseKinematicsConfig& config = {});

}  // namespace secondlook::kinematics
