#include "lib/planning/motion/plan_sweep.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/QR>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/planning/motion/stop_and_go.h"

namespace secondlook::planning {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kKnotSeconds = 0.1;  // between knots
constexpr int kBetweenKnots = 4;      // instants at which a piece is held to the line
constexpr int kCorrections = 20;
constexpr double kExact = 1e-8;  // [m] and [rad]

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// From rest to rest at a constant speed in between.
struct Course {
  double length;  // [m]
  double speed;   // [m/s]
  double run_up;  // [s]

  double seconds() const { return length / speed + run_up; }
  /// How far along it is, and how fast.
  std::pair<double, double> At(double t) const {
    const double left = seconds() - t;
    const double rate = speed / run_up;
    if (t < run_up) return {0.5 * rate * t * t, rate * t};
    if (left < run_up) return {length - 0.5 * rate * left * left, rate * left};
    return {speed * (t - 0.5 * run_up), speed};
  }
};

/// One way to make a scan: where the laser is when it begins, and where it goes, in B.
struct Line {
  Pose X_BL{Pose::Identity()};
  Eigen::Vector3d direction_B;  // unit

  Pose At(double along) const { return Eigen::Translation3d(along * direction_B) * X_BL; }
};

/// The four: either end first, the fan as given or turned by half a turn, which is the same fan.
std::vector<Line> LinesOf(const SweepGoal& goal, const Pose& X_BW) {
  std::vector<Line> lines;
  for (const double way : {1.0, -1.0}) {
    for (const double turn : {0.0, std::numbers::pi}) {
      const Pose X_BL = X_BW * goal.X_WL;
      Line line{X_BL, way * X_BL.linear().col(1)};
      line.X_BL.translation() -= 0.5 * goal.length_m * line.direction_B;
      line.X_BL.linear() = X_BL.linear() * RotationFromVector({0.0, 0.0, turn});
      lines.push_back(line);
    }
  }
  return lines;
}

/// The way from X_BA to X_BC as a translation [m] and a rotation [rad], in B.
Vector6 Difference(const Pose& X_BA, const Pose& X_BC) {
  const Eigen::AngleAxisd turn(X_BC.linear() * X_BA.linear().transpose());
  Vector6 way;
  way << X_BC.translation() - X_BA.translation(), turn.angle() * turn.axis();
  return way;
}

/// The joint angles nearest to `q` that bring the tip to `X_BE` (Newton, least change of the
/// joints); empty when that does not converge.
std::optional<Eigen::VectorXd> Corrected(const kinematics::Chain& chain, const Pose& X_BE,
                                         Eigen::VectorXd q) {
  for (int i = 0; i < kCorrections; ++i) {
    const Vector6 error = Difference(chain.TipPose(q), X_BE);
    if (error.cwiseAbs().maxCoeff() < kExact) return q;
    q += chain.Jacobian(q).completeOrthogonalDecomposition().solve(error);
    if (!q.allFinite()) return std::nullopt;
  }
  return std::nullopt;
}

PlannedSweep Refused(SweepOutcome outcome, std::string reason) {
  return {outcome, {}, {}, std::move(reason)};
}

/// Plans along single lines, from single joint angles.
class SweepPlanner {
 public:
  SweepPlanner(const Course& course, const LaserCarrier& carrier, const ArmCollision& collision,
               const SweepConfig& config)
      : course_(course), carrier_(carrier), collision_(collision), config_(config) {}

  /// The sweep along `line` that begins at `q`; without its approach.
  PlannedSweep Along(const Line& line, const Eigen::VectorXd& q) const {
    hal::JointTrajectory sweep;
    const int pieces = static_cast<int>(std::ceil(course_.seconds() / kKnotSeconds));
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(q.size());
    Eigen::VectorXd last = q;
    for (int i = 0; i <= pieces; ++i) {
      const double t = course_.seconds() * i / pieces;
      const auto [along, speed] = course_.At(t);
      const std::optional<Eigen::VectorXd> next = Corrected(chain(), FlangeAt(line, along), last);
      if (!next) {
        return Refused(SweepOutcome::kOffTheLine,
                       fmt::format("the arm is stretched out or folded too far {:.3f} m along the "
                                   "sweep",
                                   along));
      }
      Vector6 twist;
      twist << speed * line.direction_B, Eigen::Vector3d::Zero();
      const bool at_rest = i == 0 || i == pieces;
      sweep.knots.push_back(
          {t, *next,
           at_rest ? rest
                   : chain().Jacobian(*next).completeOrthogonalDecomposition().solve(twist)});
      last = *next;
    }
    if (std::string off = OffTheLine(line, sweep); !off.empty()) {
      return Refused(SweepOutcome::kOffTheLine, std::move(off));
    }
    for (std::size_t k = 1; k < sweep.knots.size(); ++k) {
      const Eigen::VectorXd& a = sweep.knots[k - 1].q;
      const Eigen::VectorXd& b = sweep.knots[k].q;
      if (StraightIsFree(collision_, a, b, config_.motion.step_m)) continue;
      const auto touch = collision_.Touches(b);
      return Refused(
          SweepOutcome::kInCollision,
          fmt::format("{:.3f} m along the sweep the arm touches something: {}",
                      course_.At(sweep.knots[k].seconds).first, touch.value_or("a little before")));
    }
    return {SweepOutcome::kFound, {}, std::move(sweep), ""};
  }

 private:
  const kinematics::Chain& chain() const { return collision_.chain(); }

  Pose FlangeAt(const Line& line, double along) const {
    return line.At(along) * carrier_.X_EL.inverse();
  }

  /// What limit the trajectory breaks, or where it leaves the line; empty when it does neither.
  std::string OffTheLine(const Line& line, const hal::JointTrajectory& sweep) const {
    try {
      hal::CheckTrajectory(sweep, "sweep", carrier_.joints, sweep.knots.front().q);
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    for (std::size_t k = 1; k < sweep.knots.size(); ++k) {
      for (int i = 1; i < kBetweenKnots; ++i) {
        const double share = static_cast<double>(i) / kBetweenKnots;
        const double t =
            (1.0 - share) * sweep.knots[k - 1].seconds + share * sweep.knots[k].seconds;
        const Vector6 off = Difference(chain().TipPose(hal::Sample(sweep, t).q) * carrier_.X_EL,
                                       line.At(course_.At(t).first));
        const double metres = off.head<3>().norm();
        const double degrees = off.tail<3>().norm() * kDegrees;
        if (metres <= config_.exact_m && degrees <= config_.exact_deg) continue;
        return fmt::format(
            "between two knots the laser leaves its line by {:.2f} mm and {:.3f} deg; exact_m "
            "allows {:.2f} mm, exact_deg {:.3f} deg",
            1e3 * metres, degrees, 1e3 * config_.exact_m, config_.exact_deg);
      }
    }
    return "";
  }

  const Course& course_;
  const LaserCarrier& carrier_;
  const ArmCollision& collision_;
  const SweepConfig& config_;
};

/// A line, and joint angles at its beginning.
struct Beginning {
  Line line;
  Eigen::VectorXd q;
  double seconds;  // to get there, if the way is free
};

}  // namespace

void SweepConfig::Validate() const {
  CheckRange(speed_m_s, 0.001, 1.0, "speed_m_s");
  CheckRange(max_length_m, 0.01, 2.0, "max_length_m");
  CheckRange(max_seconds, 0.1, 600.0, "max_seconds");
  CheckRange(run_up_s, 0.01, 5.0, "run_up_s");
  CheckRange(exact_m, 1e-6, 0.01, "exact_m");
  CheckRange(exact_deg, 1e-4, 1.0, "exact_deg");
  inverse_kinematics.Validate();
  motion.Validate();
}

SweepGoal SweepOver(const Eigen::Vector3d& p_WT, const Eigen::Vector3d& direction_W,
                    const Eigen::Vector3d& across_W, double length_m,
                    const hal::StriperInfo& striper) {
  const Eigen::Vector3d x_W = across_W.cross(direction_W);
  if (!p_WT.allFinite() || !(x_W.norm() > 1e-6 * across_W.norm() * direction_W.norm())) {
    Throw<InvalidArgument>(
        "sweep: target, direction and across must be finite, and the last two not parallel");
  }
  SweepGoal goal{Pose::Identity(), length_m};
  goal.X_WL.linear().col(2) = direction_W.normalized();
  goal.X_WL.linear().col(0) = x_W.normalized();
  goal.X_WL.linear().col(1) = goal.X_WL.linear().col(2).cross(goal.X_WL.linear().col(0));
  goal.X_WL.translation() =
      p_WT - 0.5 * (striper.min_range + striper.max_range) * direction_W.normalized();
  return goal;
}

PlannedSweep PlanSweep(const SweepGoal& goal, const LaserCarrier& carrier,
                       const ArmCollision& collision, std::uint64_t seed,
                       const SweepConfig& config) {
  config.Validate();
  const Course course{goal.length_m, config.speed_m_s, config.run_up_s};
  if (!IsValid(goal.X_WL) || !(goal.length_m >= config.speed_m_s * config.run_up_s)) {
    Throw<InvalidArgument>(
        "sweep: its middle must be a rigid transform and its length, {} m, at least the {} m of "
        "its run-up",
        goal.length_m, config.speed_m_s * config.run_up_s);
  }
  if (goal.length_m > config.max_length_m || course.seconds() > config.max_seconds) {
    return Refused(
        SweepOutcome::kTooLong,
        fmt::format("a sweep of {:.3f} m takes {:.1f} s; at most {:.3f} m and {:.1f} s "
                    "are allowed",
                    goal.length_m, course.seconds(), config.max_length_m, config.max_seconds));
  }
  const std::vector<hal::JointInfo> gentle = Gently(carrier.joints, config.motion.speed_share);
  std::vector<Beginning> beginnings;
  PlannedSweep best;
  for (const Line& line : LinesOf(goal, carrier.X_WB.inverse())) {
    const kinematics::JointSolutions solutions = SolveInverseKinematics(
        collision.chain(), {line.X_BL, carrier.X_EL, false}, carrier.q, config.inverse_kinematics);
    if (solutions.q.empty()) best.reason = solutions.reason;
    for (const Eigen::VectorXd& q : solutions.q) {
      // The solution is as exact as it is configured; the line is followed more exactly.
      const std::optional<Eigen::VectorXd> exact =
          Corrected(collision.chain(), line.X_BL * carrier.X_EL.inverse(), q);
      if (!exact) continue;
      beginnings.push_back({line, *exact, SecondsBetween(carrier.q, *exact, gentle)});
    }
  }
  std::stable_sort(beginnings.begin(), beginnings.end(),
                   [](const Beginning& a, const Beginning& b) { return a.seconds < b.seconds; });
  const SweepPlanner planner(course, carrier, collision, config);
  for (const Beginning& beginning : beginnings) {
    PlannedSweep plan = planner.Along(beginning.line, beginning.q);
    if (plan.outcome == SweepOutcome::kFound) {
      PlannedMotion approach =
          PlanMotion(collision, carrier.joints, carrier.q, beginning.q, seed, config.motion);
      if (approach.outcome == MotionOutcome::kFound) {
        plan.approach = std::move(approach.trajectory);
        return plan;
      }
      plan = Refused(SweepOutcome::kNoWay, std::move(approach.reason));
    }
    if (plan.outcome > best.outcome) best = std::move(plan);
  }
  return best;
}

}  // namespace secondlook::planning
