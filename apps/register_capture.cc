#include "apps/register_capture.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "lib/fusion/match.h"
#include "lib/perception/regroup.h"
#include "lib/perception/view.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

/// A view that lies in the map no better than this is registered by what it recognises, too …
constexpr double kLoose_m = 0.008;
/// … which a hypothesis tells when it is more likely right than not.
constexpr double kLandmarkScore = 0.5;

/// The surfaces that face away from the camera, of all that a view recognises by itself.
std::vector<perception::SurfacePoint> HiddenSides(
    const Capture& capture, const perception::Segmentation& cut,
    const std::vector<perception::RecognitionModel>& models,
    const perception::RecogniseConfig& config) {
  const perception::View view =
      perception::MakeView(capture.frame.color, capture.frame.depth, capture.camera, *cut.plane_C,
                           cut.clusters, cut.FurtherPlanes());
  const perception::Regrouped found =
      perception::RecogniseRegrouping(view, cut.clusters, models, config);
  std::vector<perception::SurfacePoint> hidden_C;
  for (const world::Detection& detection : found.detections) {
    const auto best = std::max_element(
        detection.hypotheses.begin(), detection.hypotheses.end(),
        [](const world::Hypothesis& a, const world::Hypothesis& b) { return a.score < b.score; });
    if (best == detection.hypotheses.end() || best->score < kLandmarkScore) continue;
    for (const perception::ModelPoint& p : perception::FindModel(models, best->model)->points) {
      const Vector3d p_CP = best->X_CM * p.point.cast<double>();
      const Vector3d normal_C = best->X_CM.linear() * p.normal.cast<double>();
      if (normal_C.dot(p_CP) > 0.0) hidden_C.push_back({p_CP, normal_C, SceneMap::kModelSigma_m});
    }
  }
  return hidden_C;
}

/// How far off a view's points may lie in the map, in the worst direction [m].
double SpreadOf(const perception::ViewRegistration& registration,
                const std::optional<world::SupportPlane>& plane_W) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(PointError(registration, plane_W),
                                                             Eigen::EigenvaluesOnly);
  return std::sqrt(eigen.eigenvalues().maxCoeff());
}

}  // namespace

perception::ViewRegistration RegisterCapture(
    const Capture& capture, const perception::Segmentation& cut,
    std::vector<perception::SurfacePoint> points_C,
    const std::optional<world::SupportPlane>& plane_W, const SceneMap& map,
    const std::vector<perception::RecognitionModel>& models, const UnderstandingConfig& config) {
  if (map.reference().empty()) {
    perception::ViewRegistration first;
    first.X_WC = capture.X_WC;
    first.accepted = true;
    return first;
  }
  const perception::PoseCovariance covariance = capture.covariance.value_or(
      perception::NominalCovariance(config.registration, capture.p_CB_W));
  const auto register_by = [&](const std::vector<perception::SurfacePoint>& points) {
    return perception::RegisterView(points, map.reference(), capture.X_WC, covariance,
                                    config.registration);
  };
  const perception::ViewRegistration by_surface = register_by(points_C);
  if (by_surface.accepted && SpreadOf(by_surface, plane_W) <= kLoose_m) return by_surface;
  const std::vector<perception::SurfacePoint> hidden_C =
      HiddenSides(capture, cut, models, config.recognise);
  if (hidden_C.empty()) return by_surface;
  points_C.insert(points_C.end(), hidden_C.begin(), hidden_C.end());
  const perception::ViewRegistration by_things = register_by(points_C);
  const bool better =
      by_things.accepted &&
      (!by_surface.accepted || SpreadOf(by_things, plane_W) < SpreadOf(by_surface, plane_W));
  return better ? by_things : by_surface;
}

Eigen::Matrix3d PointError(const perception::ViewRegistration& registration,
                           const std::optional<world::SupportPlane>& plane_W) {
  const Vector3d table_W = plane_W ? Vector3d((plane_W->corners_A[0] + plane_W->corners_A[2]) / 2.0)
                                   : registration.X_WC.translation();
  return fusion::PointCovariance(registration.covariance,
                                 table_W - registration.X_WC.translation()) +
         SceneMap::kModelSigma_m * SceneMap::kModelSigma_m * Eigen::Matrix3d::Identity();
}

}  // namespace secondlook::apps
