#include "lib/common/pose_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook {
namespace {

Pose At(double x, double yaw) { return ToPose(Pose2{x, 0.0, yaw}); }

TEST(PoseHistory, InterpolatesHalfWayBetweenTwoSamples) {
  PoseHistory history("X_WB", Seconds(10));
  history.Add(Time(Seconds(1)), At(0.0, 0.0));
  history.Add(Time(Seconds(3)), At(2.0, 1.0));
  const Pose2 X_WB = ToPose2(history.At(Time(Seconds(2))));
  EXPECT_NEAR(X_WB.x, 1.0, 1e-12);
  EXPECT_NEAR(X_WB.yaw, 0.5, 1e-12);
}

TEST(PoseHistory, RefusesToExtrapolateAndSaysWhatItCovers) {
  PoseHistory history("X_WB", Seconds(10));
  EXPECT_THROWS(history.At(Time(Seconds(1))), InvalidArgument, "'X_WB' is empty");
  history.Add(Time(Seconds(1)), At(0.0, 0.0));
  history.Add(Time(Seconds(3)), At(2.0, 1.0));
  EXPECT_THROWS(history.At(Time(Seconds(3.5))), InvalidArgument,
                "asked for 3.500 s, but it covers 1.000 s to 3.000 s");
}

TEST(PoseHistory, ForgetsWhatIsOlderThanItsLimit) {
  PoseHistory history("X_WB", Seconds(1));
  for (int i = 0; i <= 10; ++i) history.Add(Time(Seconds(i)), At(i, 0.0));
  EXPECT_NEAR(history.At(Time(Seconds(9.5))).translation().x(), 9.5, 1e-12);
  EXPECT_THROWS(history.At(Time(Seconds(5))), InvalidArgument, "covers");
}

TEST(PoseHistory, RefusesAPoseThatIsNotRigid) {
  PoseHistory history("X_WB", Seconds(1));
  Pose X = Pose::Identity();
  X.linear() *= 2.0;
  EXPECT_THROWS(history.Add(Time(Seconds(1)), X), InvalidArgument, "not a rigid transform");
}

}  // namespace
}  // namespace secondlook
