#include "lib/planning/motion/stop_and_go.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector2d;

const std::vector<hal::JointInfo> kJoints{{"a", -4.0, 4.0, 1.0, 2.0}, {"b", -4.0, 4.0, 0.5, 4.0}};

TEST(StopAndGo, TakesAsLongAsTheSlowestJoint) {
  // Joint b: 1.5 rad at 0.5 rad/s takes 3 s; joint a's acceleration of 2 rad/s^2 decides the ramps:
  // of 1.5 rad, it reaches 0.5 rad/s in 0.25 s.
  EXPECT_NEAR(SecondsBetween(Vector2d(0, 0), Vector2d(1.5, 1.5), kJoints), 3.0 + 0.25, 1e-9);
  // A short way: 0.02 rad at 2 rad/s^2 is 2 sqrt(0.02 / 2) s.
  EXPECT_NEAR(SecondsBetween(Vector2d(0, 0), Vector2d(0.02, 0), kJoints), 0.2, 1e-9);
  EXPECT_EQ(SecondsBetween(Vector2d(1, 2), Vector2d(1, 2), kJoints), 0.0);
}

TEST(StopAndGo, KeepsTheLimitsAndStaysOnTheStraightWays) {
  Rng rng(4);
  for (int i = 0; i < 200; ++i) {
    std::vector<Eigen::VectorXd> waypoints;
    for (int k = 0; k < 4; ++k) {
      const double scale = k % 2 == 0 ? 3.0 : 0.1;
      waypoints.push_back(Vector2d(rng.Uniform(-scale, scale), rng.Uniform(-scale, scale)));
    }
    const hal::JointTrajectory trajectory = StopAndGo(waypoints, kJoints);
    EXPECT_NO_THROW(hal::CheckTrajectory(trajectory, "arm", kJoints, waypoints.front()));
    EXPECT_EQ(trajectory.knots.back().q, waypoints.back());
    double seconds = 0.0;
    for (int k = 1; k < 4; ++k) {
      seconds += SecondsBetween(waypoints[k - 1], waypoints[k], kJoints);
    }
    EXPECT_NEAR(trajectory.seconds(), seconds, 1e-9);
    for (int step = 0; step <= 100; ++step) {
      const Eigen::VectorXd q = hal::Sample(trajectory, 0.01 * step * seconds).q;
      double nearest = std::numeric_limits<double>::infinity();
      for (int k = 1; k < 4; ++k) {
        const Eigen::VectorXd along = waypoints[k] - waypoints[k - 1];
        const double share =
            std::clamp((q - waypoints[k - 1]).dot(along) / along.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (q - waypoints[k - 1] - share * along).norm());
      }
      EXPECT_LT(nearest, 1e-9);
    }
  }
}

TEST(StopAndGo, LeavesOutWaypointsThatRepeat) {
  const hal::JointTrajectory still =
      StopAndGo({Vector2d(1, 1), Vector2d(1, 1), Vector2d(1, 1)}, kJoints);
  EXPECT_EQ(still.knots.size(), 1U);
  EXPECT_EQ(still.seconds(), 0.0);
}

TEST(StopAndGo, RefusesWhatAreNoWaypoints) {
  EXPECT_THROWS(StopAndGo({}, kJoints), InvalidArgument, "without a waypoint");
  EXPECT_THROWS(StopAndGo({Vector2d(0, 0), Eigen::Vector3d(0, 0, 0)}, kJoints), InvalidArgument,
                "waypoint 1 of a joint trajectory has not 2 finite angles");
}

}  // namespace
}  // namespace secondlook::planning
