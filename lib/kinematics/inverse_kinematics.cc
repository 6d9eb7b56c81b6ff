#include "lib/kinematics/inverse_kinematics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/common/rng.h"

namespace secondlook::kinematics {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Jacobian6 = Eigen::Matrix<double, 6, Eigen::Dynamic>;

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kArm = 0.3;  // [m] by which an angle counts as much as a distance

/// Turns the vector z = (0, 0, 1) into the direction `d` by the shortest way.
Eigen::Vector3d TurnOfAxis(const Eigen::Vector3d& d) {
  const double across = d.head<2>().norm();
  const double angle = std::atan2(across, d.z());
  if (across < 1e-12) return {angle, 0.0, 0.0};  // 0, or half a turn about any axis
  return Eigen::Vector3d(-d.y(), d.x(), 0.0) * (angle / across);
}

/// What is missing to the goal, in C: position [m], then rotation [rad].
Vector6 ErrorAt(const Chain& chain, const ToolGoal& goal, const Eigen::VectorXd& q) {
  const Pose X_CG = (chain.TipPose(q) * goal.X_EC).inverse() * goal.X_BC;
  Vector6 error;
  error.head<3>() = X_CG.translation();
  if (goal.free_roll) {
    error.tail<3>() = TurnOfAxis(X_CG.linear().col(2));
  } else {
    const Eigen::AngleAxisd turn(X_CG.linear());
    error.tail<3>() = turn.angle() * turn.axis();
  }
  return error;
}

/// How C moves, in C, with each joint.
Jacobian6 JacobianAt(const Chain& chain, const ToolGoal& goal, const Eigen::VectorXd& q) {
  const Pose X_BE = chain.TipPose(q);
  const Eigen::Matrix3d R_CB = (X_BE.linear() * goal.X_EC.linear()).transpose();
  const Eigen::Vector3d p_EC_B = X_BE.linear() * goal.X_EC.translation();
  const Jacobian6 of_E = chain.Jacobian(q);
  Jacobian6 of_C(6, of_E.cols());
  for (int i = 0; i < of_E.cols(); ++i) {
    const Eigen::Vector3d turn = of_E.col(i).tail<3>();
    of_C.col(i).head<3>() = R_CB * (of_E.col(i).head<3>() + turn.cross(p_EC_B));
    of_C.col(i).tail<3>() = R_CB * turn;
  }
  if (goal.free_roll) of_C.row(5).setZero();
  return of_C;
}

double Weigh(const Vector6& error) {
  return error.head<3>().squaredNorm() + kArm * kArm * error.tail<3>().squaredNorm();
}

/// A search from one start.
class Search {
 public:
  Search(const Chain& chain, const ToolGoal& goal, const InverseKinematicsConfig& config)
      : chain_(chain), goal_(goal), config_(config) {}

  /// Goes on from `q` as near to the goal as it gets.
  void Run(Eigen::VectorXd q) {
    q_ = std::move(q);
    error_ = ErrorAt(chain_, goal_, q_);
    double damping = 1e-3;
    for (int i = 0; i < config_.iterations && damping < 1e6 && !Exact(); ++i) {
      damping = Improve(damping) ? std::max(1e-12, 0.2 * damping) : 8.0 * damping;
    }
  }

  bool Exact() const {
    return error_.head<3>().norm() <= config_.position_m &&
           error_.tail<3>().norm() * kDegrees <= config_.rotation_deg;
  }
  const Eigen::VectorXd& q() const { return q_; }
  const Vector6& error() const { return error_; }

 private:
  /// One damped step, with the joints held that stand at a limit and would go beyond. True when it
  /// came nearer.
  bool Improve(double damping) {
    Jacobian6 jacobian = JacobianAt(chain_, goal_, q_);
    Vector6 error = error_;
    jacobian.bottomRows<3>() *= kArm;
    error.tail<3>() *= kArm;
    const Eigen::VectorXd slope = jacobian.transpose() * error;
    for (int i = 0; i < chain_.size(); ++i) {
      const Joint& joint = chain_.joint(i);
      const bool held =
          (q_[i] >= joint.upper && slope[i] > 0.0) || (q_[i] <= joint.lower && slope[i] < 0.0);
      if (held) jacobian.col(i).setZero();
    }
    Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    normal.diagonal().array() += damping * (1e-3 + normal.diagonal().array());
    const Eigen::VectorXd step = normal.ldlt().solve(jacobian.transpose() * error);
    Eigen::VectorXd q = q_ + step;
    for (int i = 0; i < chain_.size(); ++i) {
      q[i] = std::clamp(q[i], chain_.joint(i).lower, chain_.joint(i).upper);
    }
    const Vector6 next = ErrorAt(chain_, goal_, q);
    if (!(Weigh(next) < Weigh(error_))) return false;
    q_ = q;
    error_ = next;
    return true;
  }

  const Chain& chain_;
  const ToolGoal& goal_;
  const InverseKinematicsConfig& config_;
  Eigen::VectorXd q_;
  Vector6 error_;
};

/// The start of each search: `near`, the middle, and random angles that are always the same.
Eigen::VectorXd StartOf(int index, const Chain& chain, const Eigen::VectorXd& near, Rng* rng) {
  Eigen::VectorXd q(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const Joint& joint = chain.joint(i);
    if (index == 0) {
      q[i] = std::clamp(near[i], joint.lower, joint.upper);
    } else if (index == 1) {
      q[i] = 0.5 * (joint.lower + joint.upper);
    } else {
      q[i] = rng->Uniform(joint.lower, joint.upper);
    }
  }
  return q;
}

/// Seconds from one to the other when the slowest joint turns at its full speed.
double Travel(const Chain& chain, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  double seconds = 0.0;
  for (int i = 0; i < chain.size(); ++i) {
    seconds = std::max(seconds, std::abs(to[i] - from[i]) / chain.joint(i).speed);
  }
  return seconds;
}

void Check(const Chain& chain, const ToolGoal& goal, const Eigen::VectorXd& near) {
  if (!IsValid(goal.X_BC) || !IsValid(goal.X_EC)) {
    Throw<InvalidArgument>(
        "inverse kinematics: the goal X_BC or the tool X_EC is no rigid "
        "transform");
  }
  if (near.size() != chain.size() || !near.allFinite()) {
    Throw<InvalidArgument>(
        "inverse kinematics: the {} joint angles to begin with are not {} finite ones", near.size(),
        chain.size());
  }
}

}  // namespace

void InverseKinematicsConfig::Validate() const {
  CheckRange(starts, 1, 10'000, "starts");
  CheckRange(iterations, 1, 10'000, "iterations");
  CheckRange(solutions, 1, 1000, "solutions");
  CheckRange(position_m, 1e-9, 1e-4, "position_m");
  CheckRange(rotation_deg, 1e-6, 1e-2, "rotation_deg");
  CheckRange(apart_deg, 0.0, 180.0, "apart_deg");
}

JointSolutions SolveInverseKinematics(const Chain& chain, const ToolGoal& goal,
                                      const Eigen::VectorXd& near,
                                      const InverseKinematicsConfig& config) {
  config.Validate();
  Check(chain, goal, near);
  JointSolutions result;
  Rng rng(ForkSeed(0, "inverse kinematics"));
  Search search(chain, goal, config);
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < config.starts; ++i) {
    search.Run(StartOf(i, chain, near, &rng));
    if (!search.Exact()) {
      if (!(Weigh(search.error()) < best)) continue;
      best = Weigh(search.error());
      result.position_error = search.error().head<3>().norm();
      result.rotation_error = search.error().tail<3>().norm();
      continue;
    }
    const bool known = std::any_of(result.q.begin(), result.q.end(), [&](const auto& q) {
      return (q - search.q()).cwiseAbs().maxCoeff() * kDegrees < config.apart_deg;
    });
    if (!known) result.q.push_back(search.q());
    if (static_cast<int>(result.q.size()) == config.solutions) break;
  }
  if (result.q.empty()) {
    result.reason = fmt::format("unreachable: the nearest is {:.4f} m and {:.2f} deg away",
                                result.position_error, result.rotation_error * kDegrees);
    return result;
  }
  result.position_error = 0.0;
  result.rotation_error = 0.0;
  std::stable_sort(result.q.begin(), result.q.end(), [&](const auto& a, const auto& b) {
    return Travel(chain, near, a) < Travel(chain, near, b);
  });
  return result;
}

}  // namespace secondlook::kinematics
