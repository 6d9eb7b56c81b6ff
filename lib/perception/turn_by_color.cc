#include "lib/perception/turn_by_color.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "lib/perception/color_match.h"
#include "lib/perception/point_match.h"

namespace secondlook::perception {
namespace {

constexpr int kPoints = 900;
constexpr double kDegree = std::numbers::pi / 180.0;

struct Turned {
  Pose X_CM;
  double agreement;  // NaN sorted last, as -1
};

}  // namespace

double PointColorAgreement(const RecognitionModel& model, const Pose& X_CM, const View& view,
                           int label, int count) {
  if (view.color.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double tolerance = DepthTolerance(std::max(0.1, X_CM.translation().z()));
  const Eigen::Matrix3f R = X_CM.linear().cast<float>();
  const Eigen::Vector3f t = X_CM.translation().cast<float>();
  std::vector<ColorPair> pairs;
  for (int i = 0; i < count; ++i) {
    const ModelPoint& point = model.points[static_cast<std::size_t>(i)];
    const Eigen::Vector3f p = R * point.point + t;
    const Eigen::Vector3f n = R * point.normal;
    if (-n.dot(p) < 0.3F * p.norm()) continue;
    const auto pixel = view.camera.Project(p.cast<double>());
    if (!pixel) continue;
    const int x = std::clamp(static_cast<int>(pixel->x() + 0.5), 0, view.depth.cols - 1);
    const int y = std::clamp(static_cast<int>(pixel->y() + 0.5), 0, view.depth.rows - 1);
    if (view.labels.ptr<int>(y)[x] != label) continue;
    if (!(std::abs(view.depth.ptr<float>(y)[x] - p.z()) < tolerance)) continue;
    pairs.push_back({MeanColor(view.color, x, y), point.color, n});
  }
  return CompareColors(pairs);
}

std::vector<Pose> TurnByColor(const RecognitionModel& model, const Pose& X_CM, const View& view,
                              int label, int count) {
  const bool turns = model.symmetry.axis && !model.symmetry.axis_keeps_color;
  const bool moves = std::any_of(model.symmetry.motions.begin(), model.symmetry.motions.end(),
                                 [](const SymmetryMotion& motion) { return !motion.keeps_color; });
  if (view.color.empty() || (!turns && !moves)) return {X_CM};
  const int points = std::min(kPoints, static_cast<int>(model.points.size()));
  const auto rate = [&](const Pose& X, int n) {
    const double agreement = PointColorAgreement(model, X, view, label, n);
    return Turned{X, std::isnan(agreement) ? -1.0 : agreement};
  };
  std::vector<Turned> found;
  for (const SymmetryMotion& motion : model.symmetry.motions) {
    const Pose X_CS = X_CM * motion.X_MS;
    if (!turns) {
      const bool same = motion.keeps_color && !motion.X_MS.isApprox(Pose::Identity());
      if (!same) found.push_back(rate(X_CS, points));
      continue;
    }
    constexpr int kSteps = 72;
    std::vector<Turned> ring;
    for (int k = 0; k < kSteps; ++k) {
      ring.push_back(rate(X_CS * TurnAbout(*model.symmetry.axis, 5.0 * kDegree * k), points / 2));
    }
    for (int k = 0; k < kSteps; ++k) {
      const auto at = [&](int i) {
        return ring[static_cast<std::size_t>((i + kSteps) % kSteps)].agreement;
      };
      const bool maximum = at(k) >= at(k - 1) && at(k) > at(k + 1);
      if (maximum) found.push_back(ring[static_cast<std::size_t>(k)]);
    }
    if (found.empty()) found.push_back(ring.front());
  }
  const auto better = [](const Turned& a, const Turned& b) { return a.agreement > b.agreement; };
  std::stable_sort(found.begin(), found.end(), better);
  if (static_cast<int>(found.size()) > count) found.resize(static_cast<std::size_t>(count));
  if (turns) {
    for (Turned& turned : found) {
      Turned best = rate(turned.X_CM, points);
      for (const double offset : {-4, -3, -2, -1, 1, 2, 3, 4}) {
        const Turned other =
            rate(turned.X_CM * TurnAbout(*model.symmetry.axis, offset * kDegree), points);
        if (other.agreement > best.agreement) best = other;
      }
      turned = best;
    }
    std::stable_sort(found.begin(), found.end(), better);
  }
  std::vector<Pose> poses;
  for (const Turned& turned : found) poses.push_back(turned.X_CM);
  return poses;
}

Pose PolishByColor(const RecognitionModel& model, Pose X_CM, const View& view, int label) {
  if (view.color.empty()) return X_CM;
  const int points = std::min(kPoints, static_cast<int>(model.points.size()));
  const auto rate = [&](const Pose& X) {
    const double agreement = PointColorAgreement(model, X, view, label, points);
    const PointMatch match = MatchPoints(model, X, view, label, 1, points);
    const double seen = match.matching + match.see_through;
    return (std::isnan(agreement) ? 0.0 : agreement) +
           2.0 * (seen > 0.0 ? match.matching / seen : 0.0);
  };
  const Eigen::Vector3d first =
      model.symmetry.axis ? model.symmetry.axis->direction : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d second = first.unitOrthogonal();
  const std::array<Eigen::Vector3d, 3> axes{first, second, first.cross(second)};
  double best = rate(X_CM);
  for (const double step : {8.0, 4.0, 2.0, 1.0}) {
    for (const Eigen::Vector3d& axis : axes) {
      for (const double sign : {-1.0, 1.0}) {
        const Pose X = X_CM * TurnAbout({model.center_M, axis}, sign * step * kDegree);
        const double rating = rate(X);
        if (rating <= best) continue;
        best = rating;
        X_CM = X;
      }
    }
  }
  return X_CM;
}

}  // namespace secondlook::perception
