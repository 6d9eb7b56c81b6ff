#include "lib/perception/register_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/geometry/point_image.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/expect_throws.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;
using secondlook::testing::AnalyticScene;
using secondlook::testing::LookingAt;
using secondlook::testing::MakeSupport;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr geometry::CameraModel kCamera{640, 480, 577.0, 577.0, 319.5, 239.5};
constexpr double kTableHeight = 0.75;
const Vector3d kMiddle(0.0, 0.0, 0.8);

Pose At(double x, double y, double z, double yaw = 0.0) {
  Pose X = ToPose({x, y, yaw});
  X.translation().z() = z;
  return X;
}

Vector3d RandomVector(Rng* rng, double sigma) {
  return {rng->Gaussian(sigma), rng->Gaussian(sigma), rng->Gaussian(sigma)};
}

/// A table of `size` with six boxes and cylinders at random places.
AnalyticScene RandomTable(Rng* rng, const Eigen::Vector2d& size) {
  AnalyticScene scene;
  scene.boxes.push_back({At(0, 0, 0.5 * kTableHeight), Vector3d(size.x(), size.y(), kTableHeight)});
  std::vector<Eigen::Vector2d> taken;
  while (taken.size() < 6) {
    const Eigen::Vector2d p(rng->Uniform(-0.45, 0.45), rng->Uniform(-0.28, 0.28));
    if (std::any_of(taken.begin(), taken.end(),
                    [&](const Eigen::Vector2d& q) { return (p - q).norm() < 0.17; })) {
      continue;
    }
    taken.push_back(p);
    const double height = rng->Uniform(0.06, 0.24);
    if (taken.size() % 2 == 0) {
      scene.cylinders.push_back({{p.x(), p.y(), kTableHeight}, rng->Uniform(0.025, 0.06), height});
    } else {
      scene.boxes.push_back({At(p.x(), p.y(), kTableHeight + 0.5 * height, rng->Uniform(-3, 3)),
                             Vector3d(rng->Uniform(0.04, 0.12), rng->Uniform(0.05, 0.14), height)});
    }
  }
  return scene;
}

/// A depth image with the errors of a Kinect-class camera: axial and lateral noise, quantised
/// disparity, no return at depth edges.
cv::Mat Capture(const AnalyticScene& scene, const Pose& X_WC, Rng* rng) {
  const cv::Mat ideal = scene.Render(kCamera, X_WC);
  cv::Mat depth = ideal.clone();
  for (int v = 1; v + 1 < kCamera.height; ++v) {
    for (int u = 1; u + 1 < kCamera.width; ++u) {
      const auto around = {ideal.at<float>(v, u - 1), ideal.at<float>(v, u + 1),
                           ideal.at<float>(v - 1, u), ideal.at<float>(v + 1, u)};
      const auto shifted = [&](int i, int size) {
        return std::clamp(static_cast<int>(std::lround(i + rng->Gaussian(0.8))), 0, size - 1);
      };
      const double z = ideal.at<float>(shifted(v, kCamera.height), shifted(u, kCamera.width));
      const double noisy = z + rng->Gaussian(geometry::DepthSigma(z));
      const double eighths = 8.0 * 0.075 * kCamera.fx;  // of a pixel of disparity, times depth
      const bool edge = std::max(around) - std::min(around) > 0.05F;
      depth.at<float>(v, u) = edge ? std::numeric_limits<float>::quiet_NaN()
                                   : static_cast<float>(eighths / std::round(eighths / noisy));
    }
  }
  return depth;
}

/// A view with its true and its nominal pose.
struct View {
  Pose true_X_WC;
  Pose nominal_X_WC;
  Vector3d p_CB_W;
  std::vector<SurfacePoint> points_C;
};

/// A robot whose extrinsics are off by 3 mm and 0.3 degrees and whose stops by 15 mm and 0.7
/// degrees, before a random table.
class Trial {
 public:
  explicit Trial(std::uint64_t seed, const Eigen::Vector2d& table = {1.2, 0.8})
      : rng_(seed), table_(table), scene_(RandomTable(&rng_, table)) {
    extrinsics_.linear() = RotationFromVector(RandomVector(&rng_, 0.3 * kDegree));
    extrinsics_.translation() = RandomVector(&rng_, 0.003);
    from_ = rng_.Uniform(-3.0, 3.0);
  }

  View Look(double angle_deg) {
    const double angle = from_ + angle_deg * kDegree;
    const Vector3d p_WB(1.2 * std::cos(angle), 1.2 * std::sin(angle), 0.0);
    View view;
    view.true_X_WC = LookingAt(p_WB + Vector3d(0, 0, 1.2), kMiddle);
    Pose stop = ToPose({0.0, 0.0, rng_.Gaussian(0.7 * kDegree)});
    stop.translation() =
        p_WB - stop.linear() * p_WB + Vector3d(rng_.Gaussian(0.015), rng_.Gaussian(0.015), 0.0);
    view.nominal_X_WC = stop * view.true_X_WC * extrinsics_;
    view.p_CB_W = p_WB - view.true_X_WC.translation();
    const world::SupportPlane plane_C =
        world::Transform(view.true_X_WC.inverse(), MakeSupport({0, 0, kTableHeight}, table_));
    view.points_C = ViewPoints(Capture(scene_, view.true_X_WC, &rng_), kCamera, plane_C);
    return view;
  }

  const AnalyticScene& scene() const { return scene_; }

 private:
  Rng rng_;
  Eigen::Vector2d table_;
  AnalyticScene scene_;
  Pose extrinsics_{Pose::Identity()};
  double from_{};
};

/// How far the middle of the table is off, [m], and the rotation, [deg].
struct PoseError {
  double metres;
  double degrees;
};

PoseError ErrorOf(const Pose& X_WC, const Pose& true_X_WC) {
  return {(X_WC * (true_X_WC.inverse() * kMiddle) - kMiddle).norm(),
          RotationDistance(X_WC.linear(), true_X_WC.linear()) / kDegree};
}

struct Outcome {
  ViewRegistration registration;
  Pose true_X_WC;  ///< In the map, which the first view has defined.
  PoseError before;
  PoseError after;
};

/// Registers `second` to `reference`, whose first view was `first`.
Outcome Register(const View& first, const View& second, const ReferenceCloud& reference) {
  Outcome outcome;
  outcome.true_X_WC = first.nominal_X_WC * first.true_X_WC.inverse() * second.true_X_WC;
  outcome.registration = RegisterView(second.points_C, reference, second.nominal_X_WC,
                                      NominalCovariance(RegisterConfig(), second.p_CB_W));
  outcome.before = ErrorOf(second.nominal_X_WC, outcome.true_X_WC);
  outcome.after = ErrorOf(outcome.registration.X_WC, outcome.true_X_WC);
  return outcome;
}

ReferenceCloud MapOf(const View& first) {
  ReferenceCloud reference;
  reference.AddView(first.points_C, first.nominal_X_WC);
  return reference;
}

TEST(ViewPoints, LieOnTheSurfacesWithTheirNormals) {
  Trial trial(1);
  const View view = trial.Look(20.0);
  int plane = 0;
  int edge = 0;
  for (const SurfacePoint& point : view.points_C) {
    const Vector3d p_W = view.true_X_WC * point.p_AP;
    const Vector3d normal_W = view.true_X_WC.linear() * point.normal_A;
    EXPECT_NEAR(normal_W.norm(), 1.0, 1e-6);
    if (std::abs(p_W.z() - kTableHeight) > 0.006) continue;
    if (normal_W.z() > 0.99) ++plane;
    // Upright at the height of the plane: the table's edge.
    const double beside = std::max(std::abs(p_W.x()) - 0.6, std::abs(p_W.y()) - 0.4);
    if (std::abs(normal_W.z()) > 0.02 || std::abs(beside) > 0.02) continue;
    ++edge;
    EXPECT_NEAR(beside, 0.0, 0.012);
    EXPECT_GT(normal_W.dot(Vector3d(p_W.x(), p_W.y(), 0.0)), 0.0);
    EXPECT_GT(normal_W.cwiseAbs().maxCoeff(), 0.9);
  }
  EXPECT_GT(plane, 100);
  EXPECT_GT(edge, 50);
}

TEST(CovarianceBeside, HoldsWhatTheOtherViewAndBothCamerasErrBy) {
  RegisterConfig config;
  config.extrinsics_m = 0.003;
  config.extrinsics_deg = 0.01 / kDegree;
  PoseCovariance covariance = PoseCovariance::Zero();
  covariance(3, 3) = 0.004 * 0.004;
  const PoseCovariance beside = CovarianceBeside(config, covariance, {2.0, 0.0, 0.0});
  EXPECT_NEAR(beside(0, 0), 2.0 * 0.01 * 0.01, 1e-12);                    // both cameras' turns
  EXPECT_NEAR(beside(3, 3), 2.0 * 0.003 * 0.003 + 0.004 * 0.004, 1e-12);  // along the lever
  // Across it the other camera's turn counts, too: 2 m by 0.01.
  EXPECT_NEAR(beside(4, 4), 2.0 * 0.003 * 0.003 + 0.02 * 0.02, 1e-12);
  EXPECT_NEAR(beside(2, 4), 2.0 * 0.01 * 0.01, 1e-12);
  const PoseCovariance driven = NominalCovariance(RegisterConfig(), Vector3d::Zero());
  const PoseCovariance stood =
      CovarianceBeside(RegisterConfig(), PoseCovariance::Zero(), Vector3d::Zero());
  EXPECT_GT((driven - stood).diagonal().minCoeff(), 0.0);
}

TEST(RegisterView, BringsViewsThatOverlapWithin5MillimetresAndHalfADegree) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    Trial trial(seed);
    const View first = trial.Look(0.0);
    const ReferenceCloud reference = MapOf(first);
    for (const double angle_deg : {30.0, 60.0, 90.0}) {
      const Outcome outcome = Register(first, trial.Look(angle_deg), reference);
      EXPECT_TRUE(outcome.registration.accepted) << outcome.registration.reason;
      EXPECT_EQ(outcome.registration.constrained, 6);
      EXPECT_LT(outcome.after.metres, 0.005) << "seed " << seed << ", " << angle_deg << " degrees";
      EXPECT_LT(outcome.after.degrees, 0.5) << "seed " << seed << ", " << angle_deg << " degrees";
      EXPECT_LT(outcome.registration.rms, 0.004);
    }
  }
}

TEST(RegisterView, FromTheOtherSideTheTablesEdgeStillHelpsAndNothingGetsMuchWorse) {
  std::vector<double> after;
  double degrees = 0.0;
  double squared_sigmas = 0.0;
  int count = 0;
  for (std::uint64_t seed = 10; seed < 15; ++seed) {
    Trial trial(seed);
    const View first = trial.Look(0.0);
    const ReferenceCloud reference = MapOf(first);
    for (const double angle_deg : {130.0, 180.0}) {
      const Outcome outcome = Register(first, trial.Look(angle_deg), reference);
      EXPECT_LT(outcome.after.metres, outcome.before.metres + 0.01) << "seed " << seed;
      after.push_back(outcome.after.metres);
      degrees += outcome.after.degrees;
      const Eigen::AngleAxisd turn(Eigen::Matrix3d(outcome.true_X_WC.linear() *
                                                   outcome.registration.X_WC.linear().transpose()));
      Eigen::Matrix<double, 6, 1> error;
      error << turn.angle() * turn.axis(),
          outcome.true_X_WC.translation() - outcome.registration.X_WC.translation();
      squared_sigmas += error.dot(outcome.registration.covariance.inverse() * error);
      ++count;
    }
  }
  std::sort(after.begin(), after.end());
  EXPECT_LT(after[after.size() / 2], 0.008);
  EXPECT_LT(degrees / count, 0.25);
  // The covariance says about how wrong the poses are: 6 on average if it were exact.
  EXPECT_LT(squared_sigmas / count, 15.0);
  EXPECT_GT(squared_sigmas / count, 0.3);
}

TEST(RegisterView, LeavesABarePlaneWhereItIsAlongItself) {
  AnalyticScene scene;
  scene.boxes.push_back({At(0, 0, 0.5 * kTableHeight), Vector3d(8.0, 8.0, kTableHeight)});
  const world::SupportPlane plane_W = MakeSupport({0, 0, kTableHeight}, {8.0, 8.0});
  Rng rng(3);
  ReferenceCloud reference;
  const Pose first_X_WC = LookingAt({1.2, 0, 1.3}, kMiddle);
  reference.AddView(ViewPoints(Capture(scene, first_X_WC, &rng), kCamera,
                               world::Transform(first_X_WC.inverse(), plane_W)),
                    first_X_WC);
  const Pose X_WC = LookingAt({0.6, 1.0, 1.3}, kMiddle);
  const std::vector<SurfacePoint> points_C =
      ViewPoints(Capture(scene, X_WC, &rng), kCamera, world::Transform(X_WC.inverse(), plane_W));
  // 2 cm to the side, 8 mm up and 0.5 degrees of roll.
  Pose off = At(0.02, -0.01, 0.008);
  off.linear() = RotationFromVector({0.5 * kDegree, 0.0, 0.0});
  const Pose nominal_X_WC = off * X_WC;
  const ViewRegistration registration = RegisterView(
      points_C, reference, nominal_X_WC, NominalCovariance(RegisterConfig(), {-0.6, -1.0, -1.3}));
  EXPECT_TRUE(registration.accepted) << registration.reason;
  EXPECT_EQ(registration.constrained, 3);
  const Vector3d shown = registration.X_WC * (X_WC.inverse() * kMiddle);
  EXPECT_NEAR(shown.z(), kMiddle.z(), 0.002);
  const Vector3d nominal = nominal_X_WC * (X_WC.inverse() * kMiddle);
  EXPECT_NEAR((shown - nominal).head<2>().norm(), 0.0, 0.012);  // what the roll's correction moves
  // What is known afterwards: the height to millimetres, the rest as before.
  EXPECT_LT(std::sqrt(registration.covariance(5, 5)), 0.01);
  EXPECT_GT(std::sqrt(registration.covariance(3, 3)), 0.02);
}

TEST(RegisterView, AWellKnownPoseIsNotPulledAwayByAFewPairs) {
  // A plane, and a small upright surface that has been pushed by 6 mm since.
  const auto surface = [](double pushed) {
    std::vector<SurfacePoint> points;
    for (int i = 0; i < 400; ++i) {
      points.push_back({{0.02 * (i % 20), 0.02 * (i / 20), 0.0}, Vector3d::UnitZ(), 0.002});
    }
    for (int i = 0; i < 120; ++i) {
      points.push_back({{0.2 + pushed, 0.1 + 0.006 * (i % 20), 0.02 + 0.006 * (i / 20)},
                        Vector3d::UnitX(),
                        0.002});
    }
    return points;
  };
  ReferenceCloud reference;
  reference.AddView(surface(0.006), Pose::Identity());
  const auto moved = [&](double sigma) {  // of the nominal pose, in metres and radians
    const ViewRegistration registration = RegisterView(surface(0.0), reference, Pose::Identity(),
                                                       sigma * sigma * PoseCovariance::Identity());
    EXPECT_TRUE(registration.accepted) << registration.reason;
    EXPECT_EQ(registration.constrained, 5);
    return registration.X_WC.translation().x();
  };
  EXPECT_GT(moved(0.05), 0.005);   // the base may be anywhere
  EXPECT_LT(moved(0.001), 0.004);  // an arm is not
}

TEST(RegisterView, VerifiedModelsHoldAViewFromTheOtherSide) {
  // On a table too large to show its edges.
  const Eigen::Vector2d table(6.0, 6.0);
  Trial trial(21, table);
  const View first = trial.Look(0.0);
  const View second = trial.Look(180.0);
  ReferenceCloud reference = MapOf(first);
  const Outcome without = Register(first, second, reference);
  EXPECT_LT(without.after.metres, without.before.metres + 0.01);
  // The first view has verified the things where it saw them.
  const Pose X_map = first.nominal_X_WC * first.true_X_WC.inverse();
  for (std::size_t i = 1; i < trial.scene().boxes.size(); ++i) {
    const auto& box = trial.scene().boxes[i];
    reference.AddModel(geometry::MakeBox(box.size, Eigen::Vector3f::Ones()), X_map * box.X_WA,
                       0.003);
  }
  const Outcome with = Register(first, second, reference);
  EXPECT_TRUE(with.registration.accepted) << with.registration.reason;
  EXPECT_EQ(with.registration.constrained, 6);
  EXPECT_LT(with.after.metres, 0.005);
  EXPECT_LT(with.after.degrees, 0.5);
}

TEST(RegisterView, RefusesWhatIsTooFarFromTheNominalPose) {
  Trial trial(5);
  const View first = trial.Look(0.0);
  const View second = trial.Look(30.0);
  const ViewRegistration registration = RegisterView(
      second.points_C, MapOf(first), second.nominal_X_WC, 1e-6 * PoseCovariance::Identity());
  EXPECT_FALSE(registration.accepted);
  EXPECT_THAT(registration.reason, ::testing::HasSubstr("sigma from the nominal pose"));
  EXPECT_TRUE(registration.X_WC.isApprox(second.nominal_X_WC));
}

TEST(RegisterView, SaysHowManyPairsItLacks) {
  Trial trial(6);
  const View first = trial.Look(0.0);
  const PoseCovariance covariance = 1e-4 * PoseCovariance::Identity();
  const ViewRegistration registration =
      RegisterView({first.points_C[0]}, MapOf(first), first.nominal_X_WC, covariance);
  EXPECT_FALSE(registration.accepted);
  EXPECT_THAT(registration.reason,
              ::testing::HasSubstr("1 pairs within 10 mm of 1 points hold 0 directions"));
  EXPECT_FALSE(RegisterView({}, MapOf(first), first.nominal_X_WC, covariance).accepted);
}

TEST(RegisterView, RefusesBadInput) {
  const PoseCovariance covariance = 1e-4 * PoseCovariance::Identity();
  ReferenceCloud reference;
  EXPECT_THROWS(RegisterView({}, reference, Pose::Identity(), covariance), InvalidArgument,
                "reference cloud is empty");
  reference.AddModel(geometry::MakeBox({1, 1, 1}, Eigen::Vector3f::Ones()), Pose::Identity(), 0.01);
  Pose broken = Pose::Identity();
  broken.translation().x() = NAN;
  EXPECT_THROWS(RegisterView({}, reference, broken, covariance), InvalidArgument, "nominal pose");
  EXPECT_THROWS(RegisterView({}, reference, Pose::Identity(), PoseCovariance::Zero()),
                InvalidArgument, "not positive definite");
  EXPECT_THROWS(reference.AddView({}, broken), InvalidArgument, "the pose X_WC of a view");
  EXPECT_THROWS(reference.AddModel({}, Pose::Identity(), 0.01), InvalidArgument, "no triangle");
  EXPECT_THROWS(ReferenceCloud(0.0), InvalidArgument, "a cell of 0 m");
  RegisterConfig config;
  config.last_gate_m = 0.0;
  EXPECT_THROWS(config.Validate(), ConfigError, "last_gate_m = 0 must lie in 0.001..1");
}

TEST(ReferenceCloud, KeepsOnePointACellAndDirection) {
  ReferenceCloud reference(0.01);
  const Vector3d up = Vector3d::UnitZ();
  reference.AddView({{{0.001, 0.001, 0.001}, up, 0.002}}, Pose::Identity());
  reference.AddView({{{0.003, 0.001, 0.001}, up, 0.002}}, Pose::Identity());
  ASSERT_EQ(reference.Points().size(), 1U);
  EXPECT_NEAR(reference.Points()[0].p_AP.x(), 0.002, 1e-12);
  EXPECT_NEAR(reference.Points()[0].sigma, 0.002, 1e-12);
  // The other side of a thin thing is another surface.
  reference.AddView({{{0.003, 0.001, 0.002}, -up, 0.002}}, Pose::Identity());
  EXPECT_EQ(reference.Points().size(), 2U);
  reference.Remove(Eigen::AlignedBox3d(Vector3d::Zero(), Vector3d(0.01, 0.01, 0.0015)));
  ASSERT_EQ(reference.Points().size(), 1U);
  EXPECT_LT(reference.Points()[0].normal_A.z(), 0.0);
}

TEST(ReferenceCloud, AnUncertainViewCountsLess) {
  ReferenceCloud reference(0.01);
  const Vector3d up = Vector3d::UnitZ();
  PoseCovariance covariance = PoseCovariance::Zero();
  covariance(5, 5) = 0.004 * 0.004 - 0.002 * 0.002;  // 4 mm with the point's own 2 mm
  reference.AddView({{{0.001, 0.001, 0.001}, up, 0.002}}, Pose::Identity());
  reference.AddView({{{0.001, 0.001, 0.006}, up, 0.002}}, Pose::Identity(), covariance);
  ASSERT_EQ(reference.Points().size(), 1U);
  EXPECT_NEAR(reference.Points()[0].p_AP.z(), (4.0 * 0.001 + 0.006) / 5.0, 1e-9);
}

}  // namespace
}  // namespace secondlook::perception
