#include "lib/hal/joint_trajectory.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kStartTolerance = 1.0 / kDegrees;  // [rad]
constexpr double kRest = 1e-6;                      // [rad/s]
constexpr double kSlack = 1e-6;                     // relative: rounding is no violation

/// The cubic a + b t + c t^2 + d t^3 of one joint over a segment of `length` [s].
struct Cubic {
  double a{}, b{}, c{}, d{};
  double length{};

  double Position(double t) const { return a + t * (b + t * (c + t * d)); }
  double Speed(double t) const { return b + t * (2.0 * c + t * 3.0 * d); }
  double Acceleration(double t) const { return 2.0 * c + 6.0 * d * t; }
};

Cubic CubicBetween(const JointKnot& from, const JointKnot& to, int joint) {
  const double length = to.seconds - from.seconds;
  const double way = to.q[joint] - from.q[joint];
  const double v0 = from.v[joint];
  const double v1 = to.v[joint];
  return {from.q[joint], v0, (3.0 * way / length - 2.0 * v0 - v1) / length,
          (v0 + v1 - 2.0 * way / length) / (length * length), length};
}

/// Where in the segment the position or the speed may be extreme: both ends, the turning points of
/// the position and that of the speed.
std::vector<double> ExtremeInstants(const Cubic& cubic) {
  std::vector<double> instants{0.0, cubic.length};
  const auto add = [&](double t) {
    if (t > 0.0 && t < cubic.length) instants.push_back(t);  // false for NaN
  };
  add(-cubic.c / (3.0 * cubic.d));
  add(-cubic.b / (2.0 * cubic.c));
  const double root = std::sqrt(cubic.c * cubic.c - 3.0 * cubic.b * cubic.d);
  add((-cubic.c + root) / (3.0 * cubic.d));
  add((-cubic.c - root) / (3.0 * cubic.d));
  return instants;
}

void CheckKnot(const JointTrajectory& trajectory, std::size_t index, const std::string& arm,
               std::size_t joints) {
  const JointKnot& knot = trajectory.knots[index];
  const auto size = static_cast<Eigen::Index>(joints);
  if (knot.q.size() != size || knot.v.size() != size) {
    Throw<InvalidArgument>(
        "arm '{}': knot {} of the trajectory has {} positions and {} velocities for {} joints", arm,
        index, knot.q.size(), knot.v.size(), joints);
  }
  if (!std::isfinite(knot.seconds) || !knot.q.allFinite() || !knot.v.allFinite()) {
    Throw<InvalidArgument>("arm '{}': knot {} of the trajectory is not finite", arm, index);
  }
  if (index == 0 && knot.seconds != 0.0) {
    Throw<InvalidArgument>("arm '{}': the trajectory begins at {} s; it must begin at 0", arm,
                           knot.seconds);
  }
  if (index > 0 && !(knot.seconds > trajectory.knots[index - 1].seconds)) {
    Throw<InvalidArgument>("arm '{}': knot {} of the trajectory at {} s is not later than {} s",
                           arm, index, knot.seconds, trajectory.knots[index - 1].seconds);
  }
}

void CheckRest(const JointKnot& knot, const char* where, const std::string& arm,
               const std::vector<JointInfo>& joints) {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double v = knot.v[static_cast<Eigen::Index>(i)];
    if (std::abs(v) <= kRest) continue;
    Throw<InvalidArgument>(
        "arm '{}': the trajectory {} with joint '{}' at {:.2f} deg/s; it must be at rest", arm,
        where, joints[i].name, v * kDegrees);
  }
}

void CheckPosition(double q, double seconds, const std::string& arm, const JointInfo& joint) {
  if (q >= joint.lower - kSlack && q <= joint.upper + kSlack) return;
  Throw<InvalidArgument>(
      "arm '{}': the trajectory takes joint '{}' to {:.2f} deg at {:.2f} s; its limits are {:.2f} "
      "to {:.2f} deg",
      arm, joint.name, q * kDegrees, seconds, joint.lower * kDegrees, joint.upper * kDegrees);
}

void CheckLimits(const Cubic& cubic, double begin, const std::string& arm, const JointInfo& joint) {
  for (const double t : ExtremeInstants(cubic)) {
    CheckPosition(cubic.Position(t), begin + t, arm, joint);
    if (std::abs(cubic.Speed(t)) > joint.speed * (1.0 + kSlack)) {
      Throw<InvalidArgument>(
          "arm '{}': the trajectory turns joint '{}' at {:.2f} deg/s at {:.2f} s; its limit is "
          "{:.2f} deg/s",
          arm, joint.name, cubic.Speed(t) * kDegrees, begin + t, joint.speed * kDegrees);
    }
    if (std::abs(cubic.Acceleration(t)) > joint.acceleration * (1.0 + kSlack)) {
      Throw<InvalidArgument>(
          "arm '{}': the trajectory accelerates joint '{}' by {:.2f} deg/s^2 at {:.2f} s; its "
          "limit is {:.2f} deg/s^2",
          arm, joint.name, cubic.Acceleration(t) * kDegrees, begin + t,
          joint.acceleration * kDegrees);
    }
  }
}

}  // namespace

JointKnot Sample(const JointTrajectory& trajectory, double seconds) {
  const std::vector<JointKnot>& knots = trajectory.knots;
  if (seconds <= knots.front().seconds) return knots.front();
  if (seconds >= knots.back().seconds) return knots.back();
  const auto after = std::upper_bound(knots.begin(), knots.end(), seconds,
                                      [](double t, const JointKnot& k) { return t < k.seconds; });
  const JointKnot& from = *std::prev(after);
  JointKnot sample{seconds, from.q, from.v};
  for (int i = 0; i < from.q.size(); ++i) {
    const Cubic cubic = CubicBetween(from, *after, i);
    sample.q[i] = cubic.Position(seconds - from.seconds);
    sample.v[i] = cubic.Speed(seconds - from.seconds);
  }
  return sample;
}

void CheckTrajectory(const JointTrajectory& trajectory, const std::string& arm,
                     const std::vector<JointInfo>& joints, const Eigen::VectorXd& q_measured) {
  const std::vector<JointKnot>& knots = trajectory.knots;
  if (knots.empty()) Throw<InvalidArgument>("arm '{}': the trajectory has no knot", arm);
  for (std::size_t k = 0; k < knots.size(); ++k) CheckKnot(trajectory, k, arm, joints.size());
  CheckRest(knots.front(), "begins", arm, joints);
  CheckRest(knots.back(), "ends", arm, joints);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const int joint = static_cast<int>(i);
    CheckPosition(knots.front().q[joint], 0.0, arm, joints[i]);
    const double off = knots.front().q[joint] - q_measured[joint];
    if (!(std::abs(off) <= kStartTolerance)) {
      Throw<InvalidArgument>(
          "arm '{}': the trajectory begins with joint '{}' at {:.2f} deg, but it is at {:.2f} deg; "
          "plan from where the arm is",
          arm, joints[i].name, knots.front().q[joint] * kDegrees, q_measured[joint] * kDegrees);
    }
    for (std::size_t k = 1; k < knots.size(); ++k) {
      CheckLimits(CubicBetween(knots[k - 1], knots[k], joint), knots[k - 1].seconds, arm,
                  joints[i]);
    }
  }
}

}  // namespace secondlook::hal
