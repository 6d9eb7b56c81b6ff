#include "lib/kinematics/calibrate_hand.h"

#include <numbers>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/kinematics/inverse_kinematics.h"
#include "tests/support/expect_throws.h"

namespace secondlook::kinematics {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
const geometry::CameraModel kCamera{640, 480, 577.0, 579.0, 319.5, 239.5};

/// A camera in the hand of the simulated arm, and its views of a board that lies before it.
struct Rig {
  Chain arm{LoadUrdf("sim/robots/arm.urdf"), "flange"};
  Pose truth = Pose::Identity();
  std::vector<HandView> views;

  /// `count` of them, from up to `spread` [rad] off the board's normal, with corners found to
  /// within `pixels` and an arm that errs by `metres` and `radians`.
  Rig(std::uint64_t seed, int count, double spread, double pixels, double metres, double radians) {
    Rng rng(seed);
    truth.translation() = Eigen::Vector3d(0.06, 0.01, 0.03);
    truth.linear() = RotationFromRollPitchYaw(0.02, -0.03, 0.4);
    Pose X_BP = Pose::Identity();
    X_BP.translation() = Eigen::Vector3d(0.65, 0.05, 0.75);
    X_BP.linear() = RotationFromRollPitchYaw(0.1, -0.3, 0.2);
    InverseKinematicsConfig one;
    one.solutions = 1;
    Eigen::VectorXd near = Eigen::VectorXd::Constant(arm.size(), 0.5);
    for (int tries = 0; tries < 20 * count && std::ssize(views) < count; ++tries) {
      const Eigen::Vector3d from_P = RotationFromRollPitchYaw(rng.Uniform(-spread, spread),
                                                              rng.Uniform(-spread, spread), 0.0) *
                                     Eigen::Vector3d(0.0, 0.0, 0.5);
      const JointSolutions solutions = SolveInverseKinematics(
          arm, {LookAt(X_BP * from_P, X_BP.translation()), truth, true}, near, one);
      if (solutions.q.empty()) continue;
      near = solutions.q.front();
      views.push_back({near, Sight(near, X_BP, pixels, metres, radians, &rng)});
    }
  }

  double Millimetres(const Pose& X_EC) const {
    return 1e3 * (X_EC.translation() - truth.translation()).norm();
  }
  double Degrees(const Pose& X_EC) const {
    return RotationDistance(X_EC.linear(), truth.linear()) / kDegree;
  }

 private:
  SightedBoard Sight(const Eigen::VectorXd& q, const Pose& X_BP, double pixels, double metres,
                     double radians, Rng* rng) const {
    const auto draw = [&](double sigma) {
      return Eigen::Vector3d(rng->Gaussian(sigma), rng->Gaussian(sigma), rng->Gaussian(sigma));
    };
    Pose error = Pose::Identity();
    error.translation() = draw(metres);
    error.linear() = RotationFromVector(draw(radians));
    SightedBoard board;
    board.X_CP = (arm.TipPose(q) * error * truth).inverse() * X_BP;
    for (int x = -3; x <= 3; ++x) {
      for (int y = -2; y <= 2; ++y) {
        const Eigen::Vector3d p_P(0.05 * x, 0.05 * y, 0.0);
        const auto pixel = kCamera.Project(board.X_CP * p_P);
        if (!pixel) continue;
        board.points_P.push_back(p_P);
        board.corners.emplace_back(pixel->x() + rng->Gaussian(pixels),
                                   pixel->y() + rng->Gaussian(pixels));
      }
    }
    return board;
  }
};

TEST(CalibrateHand, FindsTheCameraExactlyWhereNothingErrs) {
  const Rig rig(1, 12, 0.6, 0.0, 0.0, 0.0);
  const HandCalibration found = CalibrateHand(rig.views, kCamera, rig.arm);
  EXPECT_LT(rig.Millimetres(found.X_EC), 0.01);
  EXPECT_LT(rig.Degrees(found.X_EC), 0.001);
  EXPECT_EQ(found.residuals.views, 12);
  EXPECT_LT(found.residuals.pixels, 0.01);
}

TEST(CalibrateHand, FindsItWithinAMillimetreAndATenthOfADegreeWithAllThatErrs) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const Rig rig(seed, 40, 0.7, 0.2, 0.001, 0.1 * kDegree);
    const HandCalibration found = CalibrateHand(rig.views, kCamera, rig.arm);
    EXPECT_LT(rig.Millimetres(found.X_EC), 1.0) << seed;
    EXPECT_LT(rig.Degrees(found.X_EC), 0.1) << seed;
    // What it says of itself is of the size of what it errs by.
    EXPECT_LT(found.residuals.millimetres, 0.6) << seed;
    EXPECT_GT(found.residuals.millimetres, 0.05) << seed;
    EXPECT_NEAR(found.residuals.pixels, 0.2 * std::numbers::sqrt2, 0.05) << seed;
  }
}

TEST(CalibrateHand, RefusesViewsThatDoNotTell) {
  const auto calibrate = [](const Rig& rig) { return CalibrateHand(rig.views, kCamera, rig.arm); };
  EXPECT_THROWS(calibrate(Rig(1, 7, 0.6, 0.2, 0.0, 0.0)), InvalidArgument,
                "the hand's camera found the board in 7 views, at least 8 are needed");
  Rig still(1, 1, 0.6, 0.2, 0.0, 0.0);
  still.views.resize(12, still.views.front());
  EXPECT_THROWS(calibrate(still), InvalidArgument,
                "the views turn the hand about one axis, and by 0.0 deg about any other");
}

TEST(CalibrateHand, RefusesABoardOfAnotherSize) {
  Rig rig(1, 12, 0.6, 0.2, 0.0, 0.0);
  for (HandView& view : rig.views) {
    for (Eigen::Vector3d& p_P : view.board.points_P) p_P.x() *= 1.4;
  }
  EXPECT_THROWS(CalibrateHand(rig.views, kCamera, rig.arm), InvalidArgument,
                "are the camera's intrinsics and the size of the board's squares right");
}

}  // namespace
}  // namespace secondlook::kinematics
