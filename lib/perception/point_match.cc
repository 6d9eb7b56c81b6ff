#include "lib/perception/point_match.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lib/geometry/point_to_plane.h"
#include "lib/perception/contact.h"

namespace secondlook::perception {
namespace {

constexpr float kGrazing = 0.2F;  // cosine of the incidence beyond which a point is not looked for

}  // namespace

PointMatch MatchPoints(const RecognitionModel& model, const Pose& X_CM, const View& view, int label,
                       int cluster_pixels, int count) {
  const Eigen::Matrix3f R = X_CM.linear().cast<float>();
  const Eigen::Vector3f t = X_CM.translation().cast<float>();
  const auto fx = static_cast<float>(view.camera.fx);
  const auto fy = static_cast<float>(view.camera.fy);
  const float cx = static_cast<float>(view.camera.cx) + 0.5F;
  const float cy = static_cast<float>(view.camera.cy) + 0.5F;
  const float share = static_cast<float>(model.area) / static_cast<float>(count) * fx * fy;
  const auto tolerance = static_cast<float>(DepthTolerance(std::max(0.1, X_CM.translation().z())));
  float matching = 0.0F;
  float explained = 0.0F;
  float see_through = 0.0F;
  for (int i = 0; i < count; ++i) {
    const ModelPoint& point = model.points[static_cast<std::size_t>(i)];
    const Eigen::Vector3f p = R * point.point + t;
    const Eigen::Vector3f n = R * point.normal;
    const float cosine = -n.dot(p) / p.norm();
    if (cosine < kGrazing || p.z() < 0.05F) continue;
    const float inverse = 1.0F / p.z();
    const float u = fx * p.x() * inverse + cx;
    const float v = fy * p.y() * inverse + cy;
    if (!(u >= 0.0F && v >= 0.0F)) continue;
    const auto x = static_cast<int>(u);
    const auto y = static_cast<int>(v);
    if (x >= view.depth.cols || y >= view.depth.rows) continue;
    const float difference = view.depth.ptr<float>(y)[x] - p.z();
    if (!(difference >= -tolerance)) continue;  // hidden, or nothing measured
    const float pixels = share * cosine * inverse * inverse;
    if (difference > tolerance) {
      see_through += pixels;
      continue;
    }
    matching += pixels;
    if (view.labels.ptr<int>(y)[x] == label) explained += pixels;
  }
  PointMatch match{matching, explained, see_through, 0.0};
  if (matching > 0.0F) {
    const double covered = std::min(1.0, match.explained / std::max(1, cluster_pixels));
    match.quality = match.matching / (match.matching + match.see_through) * covered * covered;
  }
  return match;
}

Pose AlignPoints(const RecognitionModel& model, Pose X_CM, const View& view, int label, int count,
                 int rounds, double gate) {
  const double tolerance = DepthTolerance(std::max(0.1, X_CM.translation().z()));
  std::vector<geometry::PointPlanePair> pairs;
  for (int round = 0; round < rounds; ++round) {
    const double reach =
        tolerance + (gate - tolerance) * (rounds - 1 - round) / std::max(1, rounds - 1);
    pairs.clear();
    for (int i = 0; i < count; ++i) {
      const ModelPoint& point = model.points[static_cast<std::size_t>(i)];
      const Eigen::Vector3d p = X_CM * point.point.cast<double>();
      const Eigen::Vector3d n = X_CM.linear() * point.normal.cast<double>();
      if (-n.dot(p) < kGrazing * p.norm()) continue;
      const auto pixel = view.camera.Project(p);
      if (!pixel) continue;
      const auto x = static_cast<int>(pixel->x() + 0.5);
      const auto y = static_cast<int>(pixel->y() + 0.5);
      if (x >= view.depth.cols || y >= view.depth.rows) continue;
      if (view.labels.ptr<int>(y)[x] != label) continue;
      const double z = view.depth.ptr<float>(y)[x];
      if (!(std::abs(z - p.z()) < reach)) continue;
      const Eigen::Vector3d q = view.camera.Ray(pixel->x(), pixel->y()) * z;
      const double off = n.dot(q - p) / (0.5 * reach);
      pairs.push_back({p, q, n, 1.0 / (1.0 + off * off)});
    }
    AddContact(model, X_CM, view.PlaneUnder(X_CM * model.center_M),
               0.1 * static_cast<double>(pairs.size()), &pairs);
    X_CM = geometry::SolvePointToPlane(pairs).X * X_CM;
  }
  return X_CM;
}

}  // namespace secondlook::perception
