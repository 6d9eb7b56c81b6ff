#include "lib/kinematics/calibrate_head.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::kinematics {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
const geometry::CameraModel kCamera{640, 480, 577.0, 579.0, 319.5, 239.5};

/// A camera that sits a little beside its nominal place, and its views of a board.
struct Rig {
  HeadCalibration nominal = HeadCalibration::AtHeight(1.25);
  HeadCalibration truth = nominal;
  std::vector<BoardView> views;

  /// Seen from `count` directions within `spread` [rad] of the board, with corners found to within
  /// `pixels` and encoders that err by `encoder` [rad].
  Rig(std::uint64_t seed, int count, double spread, double pixels, double encoder) {
    Rng rng(seed);
    truth.X_HC.translation() += Eigen::Vector3d(0.004, -0.003, 0.005);
    truth.X_HC.linear() *= RotationFromVector(Eigen::Vector3d(0.4, -0.3, 0.5) * kDegree);
    Pose X_BP = Pose::Identity();
    X_BP.translation() = Eigen::Vector3d(1.1, 0.1, 0.8);
    X_BP.linear() = RotationFromRollPitchYaw(0.2, 0.5, -0.3);
    for (int i = 0; i < count; ++i) {
      const HeadAngles head{0.09 + rng.Uniform(-spread, spread),
                            0.39 + rng.Uniform(-spread, spread)};
      const HeadAngles true_head{head.pan + rng.Gaussian(encoder),
                                 head.tilt + rng.Gaussian(encoder)};
      BoardView view;
      view.head = head;
      view.board.X_CP = CameraInBase(nominal, head).inverse() * X_BP;
      const Pose X_CP = CameraInBase(truth, true_head).inverse() * X_BP;
      for (int x = -3; x <= 3; ++x) {
        for (int y = -2; y <= 2; ++y) {
          const Eigen::Vector3d p_P(0.08 * x, 0.08 * y, 0.0);
          const auto pixel = kCamera.Project(X_CP * p_P);
          if (!pixel) continue;
          view.board.points_P.push_back(p_P);
          view.board.corners.emplace_back(pixel->x() + rng.Gaussian(pixels),
                                          pixel->y() + rng.Gaussian(pixels));
        }
      }
      views.push_back(view);
    }
  }

  double Millimetres(const HeadCalibration& c) const {
    return 1e3 * (c.X_HC.translation() - truth.X_HC.translation()).norm();
  }
  double Degrees(const HeadCalibration& c) const {
    return RotationDistance(c.X_HC.linear(), truth.X_HC.linear()) / kDegree;
  }
};

TEST(CalibrateHead, FindsTheCameraExactlyWhereNothingErrs) {
  const Rig rig(1, 12, 0.3, 0.0, 0.0);
  const Calibration found = CalibrateHead(rig.views, kCamera, rig.nominal, 0.1 * kDegree);
  EXPECT_LT(rig.Millimetres(found.head), 0.01);
  EXPECT_LT(rig.Degrees(found.head), 0.001);
  EXPECT_TRUE(found.head.X_BH0.isApprox(rig.nominal.X_BH0));
  EXPECT_EQ(found.residuals->views, 12);
  EXPECT_LT(found.residuals->pixels, 0.01);
}

TEST(CalibrateHead, FindsItWithinAMillimetreAndATenthOfADegreeWithAllThatErrs) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Rig rig(seed, 80, 0.35, 0.2, 0.1 * kDegree);
    const Calibration found = CalibrateHead(rig.views, kCamera, rig.nominal, 0.1 * kDegree);
    EXPECT_LT(rig.Millimetres(found.head), 1.0) << seed;
    EXPECT_LT(rig.Degrees(found.head), 0.1) << seed;
    // What it says of itself is of the size of what it errs by.
    EXPECT_LT(found.residuals->millimetres, 1.0) << seed;
    EXPECT_GT(found.residuals->millimetres, 0.1) << seed;
    EXPECT_NEAR(found.residuals->pixels, 0.2 * std::numbers::sqrt2, 0.05) << seed;
  }
}

TEST(CalibrateHead, RefusesViewsThatDoNotTell) {
  const auto calibrate = [](const Rig& rig) {
    return CalibrateHead(rig.views, kCamera, rig.nominal, 0.1 * kDegree);
  };
  EXPECT_THROWS(calibrate(Rig(1, 4, 0.25, 0.2, 0.0)), InvalidArgument,
                "the board was found in 4 views, at least 5 are needed");
  EXPECT_THROWS(calibrate(Rig(1, 20, 0.02, 0.2, 0.0)), InvalidArgument,
                "which does not tell where the camera sits; 10 deg of both do");
}

TEST(CalibrateHead, RefusesABoardOfAnotherSize) {
  Rig rig(1, 12, 0.25, 0.2, 0.0);
  for (BoardView& view : rig.views) {
    for (Eigen::Vector3d& p_P : view.board.points_P) p_P.x() *= 1.4;
  }
  EXPECT_THROWS(CalibrateHead(rig.views, kCamera, rig.nominal, 0.1 * kDegree), InvalidArgument,
                "are the camera's intrinsics and the size of the board's squares right");
}

}  // namespace
}  // namespace secondlook::kinematics
