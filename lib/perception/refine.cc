#include "lib/perception/refine.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "lib/geometry/point_to_plane.h"
#include "lib/perception/color_match.h"
#include "lib/perception/contact.h"
#include "lib/perception/nearest_pixel.h"
#include "lib/perception/rendered_colors.h"

namespace secondlook::perception {
namespace {

using geometry::DepthRasteriser;
using geometry::PixelRect;
using geometry::PointPlanePair;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kSurfacePairs = 500.0;
constexpr int kOutlinePixels = 8;  // how far an outline is drawn [px]

double Cauchy(double residual, double scale) {
  const double e = residual / scale;
  return 1.0 / (1.0 + e * e);
}

void AddSurfacePairs(const RecognitionModel& model, const View& view, int label,
                     const DepthRasteriser& rendered, std::vector<PointPlanePair>* pairs) {
  const PixelRect& window = rendered.window();
  const int step = std::max(1, static_cast<int>(std::sqrt(window.area() / kSurfacePairs)));
  for (int y = 0; y < window.height; y += step) {
    const float* measured = view.depth.ptr<float>(window.y + y) + window.x;
    const int* labels = view.labels.ptr<int>(window.y + y) + window.x;
    for (int x = 0; x < window.width; x += step) {
      const int at = y * window.width + x;
      const double z = rendered.depth()[static_cast<std::size_t>(at)];
      const double gate = 1.5 * DepthTolerance(z);
      if (labels[x] != label || !(std::abs(measured[x] - z) < gate)) continue;
      const Eigen::Vector3d ray = view.camera.Ray(window.x + x, window.y + y);
      const Eigen::Vector3d normal = rendered.Normal(model.mesh, at).cast<double>();
      // A slanted surface is uncertain by what one pixel makes of its depth.
      const double slant = -normal.dot(ray) / ray.norm();
      if (slant < 0.15) continue;
      const double residual = normal.dot(ray) * (measured[x] - z);
      pairs->push_back({ray * z, ray * measured[x], normal,
                        slant * Cauchy(residual, geometry::DepthSigma(z) + 0.002)});
    }
  }
}

/// Pairs in the image: outline points of the rendered silhouette toward cluster pixels it misses,
/// and from silhouette pixels seen through back to the cluster.
void AddOutlinePairs(const View& view, int label, const DepthRasteriser& rendered, double weight,
                     std::vector<PointPlanePair>* pairs) {
  const PixelRect& window = rendered.window();
  const std::size_t area = rendered.depth().size();
  std::vector<char> on_model(area);
  std::vector<char> on_cluster(area);
  for (int y = 0; y < window.height; ++y) {
    const int* labels = view.labels.ptr<int>(window.y + y) + window.x;
    for (int x = 0; x < window.width; ++x) {
      const auto at = static_cast<std::size_t>(y * window.width + x);
      on_model[at] = std::isnan(rendered.depth()[at]) ? 0 : 1;
      on_cluster[at] = labels[x] == label ? 1 : 0;
    }
  }
  const NearestPixel model(on_model, window.width, window.height, kOutlinePixels);
  const NearestPixel cluster(on_cluster, window.width, window.height, kOutlinePixels);

  const std::size_t first = pairs->size();
  const auto pull = [&](const cv::Point& from, const cv::Point& to) {
    const double z = rendered.depth()[static_cast<std::size_t>(from.y * window.width + from.x)];
    if (!(z > 0.0)) return;
    const Eigen::Vector3d p = view.camera.Ray(window.x + from.x, window.y + from.y) * z;
    const Eigen::Vector3d q = view.camera.Ray(window.x + to.x, window.y + to.y) * z;
    const double length = (q - p).norm();
    if (length < 1e-9) return;
    pairs->push_back({p, q, (q - p) / length, Cauchy(length, 3.0 * z / view.camera.fx)});
  };
  for (int y = 0; y < window.height; y += 2) {
    const float* measured = view.depth.ptr<float>(window.y + y) + window.x;
    for (int x = 0; x < window.width; x += 2) {
      const auto at = static_cast<std::size_t>(y * window.width + x);
      if (on_model[at] == on_cluster[at]) continue;
      if (on_cluster[at] != 0) {
        if (const auto from = model.To(x, y)) pull(*from, {x, y});
        continue;
      }
      const double z = rendered.depth()[at];
      if (!(measured[x] > z + DepthTolerance(z))) continue;
      if (const auto to = cluster.To(x, y)) pull({x, y}, *to);
    }
  }
  double sum = 0.0;
  for (std::size_t i = first; i < pairs->size(); ++i) sum += (*pairs)[i].weight;
  if (sum <= weight) return;
  for (std::size_t i = first; i < pairs->size(); ++i) (*pairs)[i].weight *= weight / sum;
}

/// Pairs along the gradient of the rendered tones, three for each pixel that is not hidden.
void AddColorPairs(const RecognitionModel& model, const View& view, const DepthRasteriser& rendered,
                   std::vector<PointPlanePair>* pairs) {
  constexpr double kPixels = 2500.0;
  constexpr double kToneNoise = 0.5;
  constexpr double kAlikeShare = 0.2;  // prints err alike over more pixels than depth does
  if (view.color.empty()) return;
  const PixelRect& window = rendered.window();
  const RenderedColors colors(model.mesh, rendered);
  const int step = std::max(1, static_cast<int>(std::sqrt(window.area() / kPixels)));
  std::vector<ColorPair> seen;
  std::vector<cv::Point> pixels;
  for (int y = 2; y + 2 < window.height; y += step) {
    for (int x = 2; x + 2 < window.width; x += step) {
      const bool gradient = colors.Mean(x, y) && colors.Mean(x - 1, y) && colors.Mean(x + 1, y) &&
                            colors.Mean(x, y - 1) && colors.Mean(x, y + 1);
      if (!gradient) continue;
      const int at = y * window.width + x;
      const double z = rendered.depth()[static_cast<std::size_t>(at)];
      const double measured = view.depth.at<float>(window.y + y, window.x + x);
      if (std::abs(measured - z) > DepthTolerance(z)) continue;  // NaN passes: dark or shiny
      seen.push_back({MeanColor(view.color, window.x + x, window.y + y), *colors.Mean(x, y),
                      rendered.Normal(model.mesh, at)});
      pixels.emplace_back(x, y);
    }
  }
  if (seen.size() < 20) return;
  const std::vector<Eigen::Vector3d> differences = ToneDifferences(seen);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto& [x, y] = std::pair(pixels[i].x, pixels[i].y);
    const double z = rendered.depth()[static_cast<std::size_t>(y * window.width + x)];
    const Eigen::Vector3d ray = view.camera.Ray(window.x + x, window.y + y);
    const Eigen::Vector3d du =
        0.5 * (ToneOf(*colors.Mean(x + 1, y)) - ToneOf(*colors.Mean(x - 1, y)));
    const Eigen::Vector3d dv =
        0.5 * (ToneOf(*colors.Mean(x, y + 1)) - ToneOf(*colors.Mean(x, y - 1)));
    const double depth_noise = geometry::DepthSigma(z) + 0.002;
    for (int tone = 0; tone < 3; ++tone) {
      // By how much the tone at this pixel falls as the surface point moves in C [1/m].
      const Eigen::Vector3d slope =
          du[tone] * view.camera.fx / z * Eigen::Vector3d(1.0, 0.0, -ray.x()) +
          dv[tone] * view.camera.fy / z * Eigen::Vector3d(0.0, 1.0, -ray.y());
      const double steepness = slope.norm();
      if (steepness < 1.0) continue;
      const Eigen::Vector3d direction = slope / steepness;
      const double difference = differences[i][tone];
      const double share = steepness * depth_noise / kToneNoise;
      pairs->push_back({ray * z, ray * z - direction * (difference / steepness), direction,
                        kAlikeShare * share * share * Cauchy(difference, kToneNoise)});
    }
  }
}

/// Depth and outline, in the proportions of RefinePose(). Returns what contact weighs beside them.
double AddShapePairs(const RecognitionModel& model, const View& view, int label,
                     const DepthRasteriser& rendered, std::vector<PointPlanePair>* pairs) {
  AddSurfacePairs(model, view, label, rendered, pairs);
  const auto surface = static_cast<double>(pairs->size());
  AddOutlinePairs(view, label, rendered, 0.3 * surface, pairs);
  return 0.1 * surface;
}

/// What holds a model in a view, linearised: of (rotation vector [rad], translation [m]) of its
/// centre, in M.
struct NormalEquations {
  Matrix6 information{Matrix6::Zero()};
  Vector6 right_side{Vector6::Zero()};
};

NormalEquations Linearise(const RecognitionModel& model, const Pose& X_CM, const View& view,
                          int label, DepthRasteriser* rasteriser) {
  NormalEquations equations;
  const PixelRect window = geometry::ImageBounds(model.mesh, X_CM, view.camera, 6);
  if (window.empty()) return equations;
  rasteriser->Render(model.mesh, X_CM, view.camera, window);
  std::vector<PointPlanePair> pairs_C;
  const double contact = AddShapePairs(model, view, label, *rasteriser, &pairs_C);
  // Not everything stands on what is flat; the views together know its tilt.
  AddContactHeight(model, X_CM, view.PlaneUnder(X_CM * model.center_M), contact, &pairs_C);
  AddColorPairs(model, view, *rasteriser, &pairs_C);
  const Pose X_MC = X_CM.inverse();
  for (const PointPlanePair& pair : pairs_C) {
    const Eigen::Vector3d normal = X_MC.linear() * pair.normal_A;
    Vector6 slope;
    slope << (X_MC * pair.p_AP - model.center_M).cross(normal), normal;
    equations.information += pair.weight * slope * slope.transpose();
    equations.right_side += pair.weight * pair.normal_A.dot(pair.p_AQ - pair.p_AP) * slope;
  }
  // Neighbouring measurements err alike: so many count as one.
  constexpr double kAlike = 10.0;
  const double sigma = geometry::DepthSigma((X_CM * model.center_M).z()) + 0.002;
  equations.information /= kAlike * sigma * sigma;
  equations.right_side /= kAlike * sigma * sigma;
  return equations;
}

/// So far a step goes where nothing holds it.
Matrix6 Damping() {
  constexpr double kTurn = 0.03;    // [rad]
  constexpr double kShift = 0.003;  // [m]
  Vector6 damping;
  damping << Eigen::Vector3d::Constant(1.0 / (kTurn * kTurn)),
      Eigen::Vector3d::Constant(1.0 / (kShift * kShift));
  return damping.asDiagonal();
}

/// The motion of M that turns and shifts it at its point `center_M`.
Pose MotionAbout(const Eigen::Vector3d& center_M, const Vector6& motion) {
  Pose X = Pose::Identity();
  X.linear() = RotationFromVector(motion.head<3>());
  X.translation() = center_M + motion.tail<3>() - X.linear() * center_M;
  return X;
}

/// The covariance of the origin's motion from that of the motion at `center_M`.
Matrix6 ToOrigin(const Matrix6& covariance, const Eigen::Vector3d& center_M) {
  Matrix6 lever = Matrix6::Identity();
  lever.bottomLeftCorner<3, 3>() << 0.0, -center_M.z(), center_M.y(),  //
      center_M.z(), 0.0, -center_M.x(),                                //
      -center_M.y(), center_M.x(), 0.0;
  return lever * covariance * lever.transpose();
}

}  // namespace

Pose RefinePose(const RecognitionModel& model, Pose X_CM, const View& view, int label, int rounds,
                DepthRasteriser* rasteriser) {
  std::vector<PointPlanePair> pairs;
  for (int round = 0; round < rounds; ++round) {
    const PixelRect window = geometry::ImageBounds(model.mesh, X_CM, view.camera, 6);
    if (window.empty()) return X_CM;
    rasteriser->Render(model.mesh, X_CM, view.camera, window);
    pairs.clear();
    const double contact = AddShapePairs(model, view, label, *rasteriser, &pairs);
    AddContact(model, X_CM, view.PlaneUnder(X_CM * model.center_M), contact, &pairs);
    X_CM = geometry::SolvePointToPlane(pairs).X * X_CM;
  }
  return X_CM;
}

JointPose RefineTogether(const RecognitionModel& model, const std::vector<PlacedModel>& placed,
                         const RegistrationSigma& registration, int rounds,
                         DepthRasteriser* rasteriser) {
  Vector6 free_variance;  // of a view against the others
  free_variance << Eigen::Vector3d::Constant(std::pow(registration.rotation, 2)),
      Eigen::Vector3d::Constant(std::pow(registration.translation, 2));
  JointPose joint;
  std::vector<NormalEquations> views;
  Matrix6 information = Matrix6::Zero();
  Vector6 step = Vector6::Zero();
  for (int round = 0; round < rounds; ++round) {
    views.clear();
    information.setZero();
    Vector6 right_side = Vector6::Zero();
    for (const PlacedModel& p : placed) {
      views.push_back(Linearise(model, p.X_CM * joint.X_MS, *p.view, p.label, rasteriser));
      // With the motion of the view's own taken out (the Schur complement).
      const Matrix6 share =
          (Matrix6::Identity() + views.back().information * free_variance.asDiagonal()).inverse();
      information += share * views.back().information;
      right_side += share * views.back().right_side;
    }
    step = (information + Damping()).ldlt().solve(right_side);
    joint.X_MS = joint.X_MS * MotionAbout(model.center_M, step);
  }
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const Matrix6 own = views[i].information + Matrix6(free_variance.cwiseInverse().asDiagonal());
    const Vector6 left = views[i].right_side - views[i].information * step;
    joint.X_CM.push_back(placed[i].X_CM * joint.X_MS *
                         MotionAbout(model.center_M, own.ldlt().solve(left)));
  }
  joint.covariance = ToOrigin((information + Damping()).inverse(), model.center_M);
  return joint;
}

}  // namespace secondlook::perception
