#include "apps/experiments/ppf_peer.h"

#include <algorithm>
#include <limits>

#include <opencv2/surface_matching.hpp>

namespace secondlook::apps {
namespace {

namespace peer = cv::ppf_match_3d;
using geometry::OrientedPoint;

/// Rows of point and normal.
template <class Point>
cv::Mat ToMat(const std::vector<Point>& points) {
  cv::Mat mat(static_cast<int>(points.size()), 6, CV_32FC1);
  for (int i = 0; i < mat.rows; ++i) {
    const Point& point = points[static_cast<std::size_t>(i)];
    std::copy_n(point.point.data(), 3, mat.ptr<float>(i));
    std::copy_n(point.normal.data(), 3, mat.ptr<float>(i) + 3);
  }
  return mat;
}

Pose ToPose(const cv::Matx44d& matrix) {
  Pose X = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) X(row, column) = matrix(row, column);
  }
  X.linear() = Eigen::Quaterniond(X.linear()).normalized().toRotationMatrix();
  return X;
}

/// `spacing` as a share of the diagonal of the box around the points, to which the peer's sampling
/// is relative.
double Relative(double spacing, const std::vector<OrientedPoint>& points) {
  Eigen::AlignedBox3f box;
  for (const OrientedPoint& point : points) box.extend(point.point);
  return spacing / static_cast<double>(box.diagonal().norm());
}

std::vector<OrientedPoint> Thin(const std::vector<OrientedPoint>& points, double spacing) {
  constexpr double kAngle = 0.6;  // [rad], as our own voting has it
  std::vector<OrientedPoint> thinned;
  for (const int i : geometry::SubsampleByNormals(points, spacing, kAngle)) {
    thinned.push_back(points[static_cast<std::size_t>(i)]);
  }
  return thinned;
}

/// The points of the model that face the camera at X_CM: its back has nothing to be aligned with.
std::vector<perception::ModelPoint> FacingCamera(const perception::RecognitionModel& model,
                                                 const Pose& X_CM) {
  std::vector<perception::ModelPoint> facing;
  for (const perception::ModelPoint& point : model.points) {
    const Eigen::Vector3d n_C = X_CM.linear() * point.normal.cast<double>();
    if (n_C.dot(X_CM * point.point.cast<double>()) < 0.0) facing.push_back(point);
  }
  return facing;
}

}  // namespace

PpfPeer::PpfPeer(const perception::RecognitionModel& model) : model_(&model) {
  const double sampling = Relative(model.ppf.spacing, model.ppf.points);
  detector_ = std::make_unique<peer::PPF3DDetector>(sampling, sampling);
  // It would gather poses by the distance of their positions alone (its limit for rotations is 30
  // radians), 0.05 units of length by default, and return the mean of their rotations. In OpenCV's
  // example, in millimetres, this never happens; in metres it mixes all that the votes found.
  constexpr double kNever = 1e-9;
  detector_->setSearchParams(kNever, kNever);
  detector_->trainModel(ToMat(model.ppf.points));
}

PpfPeer::~PpfPeer() = default;
PpfPeer::PpfPeer(PpfPeer&&) noexcept = default;
PpfPeer& PpfPeer::operator=(PpfPeer&&) noexcept = default;

std::vector<PeerPose> PpfPeer::Match(const std::vector<OrientedPoint>& cloud_C, int count) const {
  constexpr std::size_t kLeastPoints = 10;
  const double spacing = model_->ppf.spacing;
  const std::vector<OrientedPoint> thinned_C = Thin(cloud_C, spacing);
  if (thinned_C.size() < kLeastPoints) return {};
  std::vector<peer::Pose3DPtr> found;
  detector_->match(ToMat(thinned_C), found, 1.0, Relative(spacing, thinned_C));
  found.resize(std::min(found.size(), static_cast<std::size_t>(count)));
  const cv::Mat scene_C = ToMat(cloud_C);
  std::vector<PeerPose> poses;
  for (const peer::Pose3DPtr& pose : found) {
    const Pose X_voted = ToPose(pose->pose);
    std::vector<peer::Pose3DPtr> aligned{pose};
    // OpenCV's example has 8 levels, for clouds of tens of thousands of points.
    peer::ICP(100, 0.005F, 2.5F, 4)
        .registerModelToScene(ToMat(FacingCamera(*model_, X_voted)), scene_C, aligned);
    // Where it loses all pairs, it returns a pose far away and this residual.
    constexpr double kLost = 1e9;
    const bool lost = !cv::checkRange(cv::Mat(pose->pose)) || !(pose->residual < kLost);
    const auto votes = static_cast<int>(pose->numVotes);
    poses.push_back({lost ? X_voted : ToPose(pose->pose), votes,
                     votes / static_cast<double>(thinned_C.size() - 1),
                     lost ? std::numeric_limits<double>::infinity() : pose->residual});
  }
  return poses;
}

}  // namespace secondlook::apps
