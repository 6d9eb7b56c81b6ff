#include "lib/kinematics/calibrate_hand.h"

#include <numbers>

#include <Eigen/SVD>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "lib/common/error.h"

namespace secondlook::kinematics {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kMinViews = 8;
constexpr double kMinTurn = 15.0 * kDegree;

/// From one end to the other, the turns of the hand about the second of their main axes [rad].
double TurnAboutASecondAxis(const std::vector<Pose>& X_BE) {
  Eigen::MatrixX3d turns(X_BE.size(), 3);
  for (std::size_t i = 0; i < X_BE.size(); ++i) {
    const Eigen::AngleAxisd turn(X_BE.front().linear().transpose() * X_BE[i].linear());
    turns.row(static_cast<Eigen::Index>(i)) = turn.angle() * turn.axis();
  }
  turns.rowwise() -= turns.colwise().mean().eval();
  const Eigen::MatrixX3d along =
      turns * Eigen::JacobiSVD<Eigen::MatrixXd>(turns, Eigen::ComputeThinV).matrixV();
  return along.col(1).maxCoeff() - along.col(1).minCoeff();
}

void RequireSpread(const std::vector<Pose>& X_BE) {
  if (X_BE.size() < kMinViews) {
    Throw<InvalidArgument>(
        "the hand's camera found the board in {} views, at least {} are needed: light it well, and "
        "put it where the arm can look at it from several sides",
        X_BE.size(), kMinViews);
  }
  const double turn = TurnAboutASecondAxis(X_BE);
  if (turn < kMinTurn) {
    Throw<InvalidArgument>(
        "the views turn the hand about one axis, and by {:.1f} deg about any other, which does not "
        "tell where the camera sits; {:.0f} deg do: let it look at the board from several sides",
        turn / kDegree, kMinTurn / kDegree);
  }
}

/// X_EC in closed form.
Pose SolveHandEye(const std::vector<Pose>& X_BE, const std::vector<HandView>& views) {
  const auto split = [](const Pose& X_AB, std::vector<cv::Mat>* rotations,
                        std::vector<cv::Mat>* translations) {
    cv::eigen2cv(Eigen::Matrix3d(X_AB.linear()), rotations->emplace_back());
    cv::eigen2cv(Eigen::Vector3d(X_AB.translation()), translations->emplace_back());
  };
  std::vector<cv::Mat> R_BE;
  std::vector<cv::Mat> p_BE;
  std::vector<cv::Mat> R_CP;
  std::vector<cv::Mat> p_CP;
  for (std::size_t i = 0; i < views.size(); ++i) {
    split(X_BE[i], &R_BE, &p_BE);
    split(views[i].board.X_CP, &R_CP, &p_CP);
  }
  cv::Mat R_EC;
  cv::Mat p_EC;
  cv::calibrateHandEye(R_BE, p_BE, R_CP, p_CP, R_EC, p_EC, cv::CALIB_HAND_EYE_PARK);
  Eigen::Matrix3d R;
  Eigen::Vector3d p;
  cv::cv2eigen(R_EC, R);
  cv::cv2eigen(p_EC, p);
  Pose X_EC = Pose::Identity();
  X_EC.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
  X_EC.translation() = p;
  return X_EC;
}

/// What errs by (rotation [rad], translation [m]).
Pose ToPose(const Eigen::VectorXd& twist) {
  Pose X = Pose::Identity();
  X.linear() = RotationFromVector(twist.head<3>());
  X.translation() = twist.tail<3>();
  return X;
}

}  // namespace

HandCalibration CalibrateHand(const std::vector<HandView>& views,
                              const geometry::CameraModel& camera, const Chain& arm,
                              const ArmErrors& errors) {
  std::vector<Pose> X_BE;
  std::vector<CarriedView> carried;
  for (const HandView& view : views) {
    X_BE.push_back(arm.TipPose(view.q));
    carried.push_back({view.board, [X = X_BE.back()](const Eigen::VectorXd& error) {
                         return X * ToPose(error);
                       }});
  }
  RequireSpread(X_BE);
  CarriedCamera start;
  start.X_EC = SolveHandEye(X_BE, views);
  start.X_BP = X_BE.front() * start.X_EC * views.front().board.X_CP;
  Eigen::VectorXd sigmas(6);
  sigmas << Eigen::Vector3d::Constant(errors.radians), Eigen::Vector3d::Constant(errors.metres);
  const CarriedCamera found = CalibrateCarriedCamera(carried, camera, start, sigmas);
  return {
      found.X_EC,
      {static_cast<int>(views.size()), found.pixels, 1e3 * found.metres, found.radians / kDegree}};
}

}  // namespace secondlook::kinematics
