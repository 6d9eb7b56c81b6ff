#include "lib/hal/joint_trajectory.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::hal {
namespace {

Eigen::VectorXd Vector(double x) { return Eigen::VectorXd::Constant(1, x); }

const std::vector<JointInfo> kJoint{{"elbow", -1.0, 2.0, 0.5, 2.0}};

/// From rest at `from` over `way` in `seconds`.
JointTrajectory Move(double from, double way, double seconds) {
  return {{{0.0, Vector(from), Vector(0.0)}, {seconds, Vector(from + way), Vector(0.0)}}};
}

void Check(const JointTrajectory& trajectory, double measured = 0.0) {
  CheckTrajectory(trajectory, "left", kJoint, Vector(measured));
}

TEST(Sample, FollowsTheCubicBetweenKnots) {
  // From rest to rest over 1 rad in 2 s: s = 3 u^2 - 2 u^3, u = t / 2.
  const JointTrajectory move = Move(0.0, 1.0, 2.0);
  EXPECT_NEAR(Sample(move, 0.5).q[0], 3 * 0.0625 - 2 * 0.015625, 1e-12);
  EXPECT_NEAR(Sample(move, 1.0).q[0], 0.5, 1e-12);
  EXPECT_NEAR(Sample(move, 1.0).v[0], 0.75, 1e-12);
}

TEST(Sample, HoldsTheFirstAndTheLastKnot) {
  const JointTrajectory move = Move(0.3, 1.0, 2.0);
  EXPECT_EQ(Sample(move, -1.0).q[0], 0.3);
  EXPECT_EQ(Sample(move, 9.0).q[0], 1.3);
}

TEST(CheckTrajectory, AcceptsWhatKeepsEveryLimit) {
  // At most 1.5 x 0.6 / 2 = 0.45 rad/s and 6 x 0.6 / 4 = 0.9 rad/s^2.
  EXPECT_NO_THROW(Check(Move(0.0, 0.6, 2.0)));
}

TEST(CheckTrajectory, SeesTheSpeedBetweenKnots) {
  // 0.525 rad/s in the middle, where there is no knot.
  EXPECT_THROWS(
      Check(Move(0.0, 0.7, 2.0)), InvalidArgument,
      "arm 'left': the trajectory turns joint 'elbow' at 30.08 deg/s at 1.00 s; its limit "
      "is 28.65 deg/s");
}

TEST(CheckTrajectory, SeesTheAccelerationOfAShortMove) {
  // 6 x 0.1 / 0.5^2 = 2.4 rad/s^2, at no more than 0.3 rad/s.
  EXPECT_THROWS(Check(Move(0.0, 0.1, 0.5)), InvalidArgument, "accelerates joint 'elbow' by 137.51");
}

TEST(CheckTrajectory, SeesAPositionBeyondTheLimitBetweenKnots) {
  // Both knots lie within, but it passes the first at speed and swings out before it turns back.
  JointTrajectory swing = Move(1.95, -0.5, 4.0);
  swing.knots.insert(swing.knots.begin() + 1, {0.5, Vector(1.98), Vector(0.3)});
  EXPECT_THROWS(Check(swing, 1.95), InvalidArgument, "its limits are -57.30 to 114.59 deg");
}

TEST(CheckTrajectory, AgreesWithDenseSamplingOverRandomCubics) {
  Rng rng(7);
  int refused = 0;
  for (int i = 0; i < 500; ++i) {
    JointTrajectory move = Move(0.0, rng.Uniform(-1.0, 1.0), rng.Uniform(1.5, 5.0));
    move.knots.insert(move.knots.begin() + 1, {0.5 * move.seconds(), Vector(rng.Uniform(-0.6, 0.6)),
                                               Vector(rng.Uniform(-0.3, 0.3))});
    double highest = -10.0, lowest = 10.0, fastest = 0.0, hardest = 0.0;
    const double step = 1e-4;
    for (double t = 0.0; t <= move.seconds(); t += step) {
      const JointKnot now = Sample(move, t);
      highest = std::max(highest, now.q[0]);
      lowest = std::min(lowest, now.q[0]);
      fastest = std::max(fastest, std::abs(now.v[0]));
      if (t > 0.0 && t < 0.5 * move.seconds() - step) {
        hardest = std::max(hardest, std::abs(Sample(move, t + step).v[0] - now.v[0]) / step);
      }
      if (t > 0.5 * move.seconds() && t < move.seconds() - step) {
        hardest = std::max(hardest, std::abs(Sample(move, t + step).v[0] - now.v[0]) / step);
      }
    }
    const bool breaks = highest > 2.0 || lowest < -1.0 || fastest > 0.5 || hardest > 2.0;
    const double nearest = std::min(std::abs(fastest - 0.5), std::abs(hardest - 2.0));
    if (nearest < 2e-3) continue;  // too near to a limit for the sampling to tell
    refused += breaks;
    if (breaks) {
      EXPECT_THROW(Check(move), InvalidArgument) << i;
    } else {
      EXPECT_NO_THROW(Check(move)) << i;
    }
  }
  EXPECT_GT(refused, 50);
  EXPECT_LT(refused, 450);
}

}  // namespace
}  // namespace secondlook::hal
