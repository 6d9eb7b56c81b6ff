#include "lib/perception/hypothesise.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lib/geometry/normals.h"
#include "lib/perception/point_match.h"
#include "lib/perception/turn_by_color.h"

namespace secondlook::perception {
namespace {

using geometry::OrientedPoint;

constexpr int kRoughPoints = 150;
constexpr int kFinePoints = 300;
constexpr int kFollowed = 6;  // guesses aligned with care, for each that is kept

/// The largest distance between two points of the cluster along a few directions [m], from below:
/// no model of a smaller diameter can have made it.
double ExtentOf(const std::vector<OrientedPoint>& surface) {
  double extent = 0.0;
  for (int k = 0; k < 13; ++k) {
    // The 13 directions to the neighbours of a cube's cell.
    const int code = k + 14;
    const Eigen::Vector3f direction =
        Eigen::Vector3f(static_cast<float>(code % 3 - 1), static_cast<float>(code / 3 % 3 - 1),
                        static_cast<float>(code / 9 - 1))
            .normalized();
    std::vector<float> along;
    along.reserve(surface.size());
    for (const OrientedPoint& point : surface) along.push_back(direction.dot(point.point));
    if (along.size() < 10) return 0.0;
    // A hundredth at either end may be noise.
    const auto cut = static_cast<std::ptrdiff_t>(along.size() / 100);
    std::nth_element(along.begin(), along.begin() + cut, along.end());
    const float low = along[static_cast<std::size_t>(cut)];
    std::nth_element(along.begin(), along.end() - 1 - cut, along.end());
    extent = std::max(
        extent, static_cast<double>(along[along.size() - 1 - static_cast<std::size_t>(cut)] - low));
  }
  return extent;
}

/// The model resting on `down_M`, turned by `yaw` about the plane's normal, its visible surface
/// centred on the cluster's.
Pose RestAt(const RecognitionModel& model, const Eigen::Vector3d& down_M, double yaw,
            const world::SupportPlane& plane_C, const Eigen::Vector3d& center_C) {
  Pose X_CM = Pose::Identity();
  X_CM.linear() = Eigen::AngleAxisd(yaw, plane_C.normal_A).toRotationMatrix() *
                  Eigen::Quaterniond::FromTwoVectors(down_M, -plane_C.normal_A).toRotationMatrix();
  X_CM.translation() = center_C - X_CM.linear() * model.center_M;
  const auto stand = [&] {
    X_CM.translation() -= LowestHeight(model, X_CM, plane_C) * plane_C.normal_A;
  };
  stand();
  for (int i = 0; i < 2; ++i) {
    Eigen::Vector3d shift = center_C - VisibleMean(model, X_CM);
    shift -= shift.dot(plane_C.normal_A) * plane_C.normal_A;
    X_CM.translation() += shift;
  }
  return X_CM;
}

void AddResting(const RecognitionModel& model, const View& view, const Eigen::Vector3d& center_C,
                std::vector<Pose>* poses) {
  constexpr int kYaws = 24;
  for (const Eigen::Vector3d& down_M : model.resting_M) {
    const bool turns =
        model.symmetry.axis && std::abs(model.symmetry.axis->direction.dot(down_M)) > 0.99;
    const int yaws = turns ? 1 : kYaws;
    for (int k = 0; k < yaws; ++k) {
      poses->push_back(RestAt(model, down_M, 2.0 * std::numbers::pi * k / kYaws,
                              view.PlaneUnder(center_C), center_C));
    }
  }
}

void AddVoted(const RecognitionModel& model, const std::vector<OrientedPoint>& surface_C,
              std::vector<Pose>* poses) {
  constexpr int kPartners = 160;
  constexpr int kReferences = 24;
  constexpr std::size_t kKept = 16;
  std::vector<OrientedPoint> scene;
  double spacing = model.ppf.spacing;
  do {
    scene.clear();
    for (const int i : geometry::SubsampleByNormals(surface_C, spacing, 0.6)) {
      scene.push_back(surface_C[static_cast<std::size_t>(i)]);
    }
    spacing *= 1.2;
  } while (static_cast<int>(scene.size()) > kPartners);
  const int stride = std::max(1, static_cast<int>(scene.size()) / kReferences);
  const std::vector<PosePeak> clusters =
      ClusterPeaks(VotePpf(model.ppf, scene, stride), model.symmetry, model.center_M,
                   0.1 * model.diameter, 0.25);
  for (std::size_t i = 0; i < std::min(kKept, clusters.size()); ++i) {
    poses->push_back(clusters[i].X_CM);
  }
}

/// The best `count` of `guesses`, best first, no two within `angle` [rad] and `distance` [m].
std::vector<PoseGuess> KeepDistinct(std::vector<PoseGuess> guesses, const RecognitionModel& model,
                                    double distance, double angle, int count) {
  std::stable_sort(guesses.begin(), guesses.end(),
                   [](const PoseGuess& a, const PoseGuess& b) { return a.quality > b.quality; });
  std::vector<PoseGuess> kept;
  for (const PoseGuess& guess : guesses) {
    if (static_cast<int>(kept.size()) >= count) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const PoseGuess& other) {
      const PoseDistance d =
          DistanceUpToSymmetry(other.X_CM, guess.X_CM, model.symmetry, model.center_M, false);
      return d.translation < distance && d.rotation < angle;
    });
    if (!known) kept.push_back(guess);
  }
  return kept;
}

/// How well the colours agree at the best of the poses that have the same shape; 1 where colour
/// says nothing, or a turn about an axis would have to be searched first.
double ColorShare(const RecognitionModel& model, const Pose& X_CM, const View& view, int label) {
  if (view.color.empty() || model.symmetry.axis) return 1.0;
  double best = 0.0;
  for (const SymmetryMotion& motion : model.symmetry.motions) {
    const double agreement =
        PointColorAgreement(model, X_CM * motion.X_MS, view, label, kFinePoints);
    if (std::isnan(agreement)) return 1.0;
    best = std::max(best, agreement);
  }
  return best;
}

}  // namespace

std::vector<OrientedPoint> OrientCluster(const View& view, int label,
                                         const world::Cluster& cluster) {
  constexpr int kMost = 1200;
  const int step =
      std::max(2, static_cast<int>(std::sqrt(static_cast<double>(cluster.pixels.size()) / kMost)));
  std::vector<OrientedPoint> surface;
  for (const int pixel : cluster.pixels) {
    if (pixel % view.camera.width % step != 0 || pixel / view.camera.width % step != 0) continue;
    if (view.labels.at<int>(pixel / view.camera.width, pixel % view.camera.width) != label) {
      continue;
    }
    const auto point = geometry::FitLocalPlane(view.depth, view.labels, view.camera, pixel);
    if (point) surface.push_back(*point);
  }
  return surface;
}

Eigen::Vector3d VisibleMean(const RecognitionModel& model, const Pose& X_CM) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weights = 0.0;
  for (int i = 0; i < kRoughPoints; ++i) {
    const ModelPoint& point = model.points[static_cast<std::size_t>(i)];
    const Eigen::Vector3d p = X_CM * point.point.cast<double>();
    const double cosine = -(X_CM.linear() * point.normal.cast<double>()).dot(p) / p.norm();
    if (cosine <= 0.1) continue;
    sum += cosine * p;
    weights += cosine;
  }
  return weights > 0.0 ? Eigen::Vector3d(sum / weights) : X_CM * model.center_M;
}

std::vector<PoseGuess> HypothesisePoses(const RecognitionModel& model, const View& view, int label,
                                        const world::Cluster& cluster,
                                        const std::vector<OrientedPoint>& surface_C, int count) {
  if (surface_C.size() < 10) return {};
  if (ExtentOf(surface_C) > 1.1 * model.diameter + 0.015) return {};
  std::vector<Pose> poses;
  AddResting(model, view, cluster.center_C, &poses);
  AddVoted(model, surface_C, &poses);

  const auto pixels = static_cast<int>(cluster.pixels.size());
  const auto quality = [&](const Pose& X_CM, int points) {
    return MatchPoints(model, X_CM, view, label, pixels, points).quality;
  };
  /// Alignment may lose what is thin: it is drawn to what lies beside it.
  const auto keep_better = [&](const Pose& X_CM, int points, PoseGuess* guess) {
    const double other = quality(X_CM, points);
    if (other >= guess->quality) *guess = {X_CM, other};
  };
  std::vector<PoseGuess> guesses;
  for (const Pose& X_CM : poses) {
    PoseGuess guess{X_CM, quality(X_CM, kRoughPoints)};
    keep_better(AlignPoints(model, X_CM, view, label, kRoughPoints / 2, 2, 0.04), kRoughPoints,
                &guess);
    guesses.push_back(guess);
  }
  guesses = KeepDistinct(std::move(guesses), model, 0.02, 0.2, kFollowed * count);
  for (PoseGuess& guess : guesses) {
    guess.quality = quality(guess.X_CM, kFinePoints);
    Pose X_CM = guess.X_CM;
    for (const double gate : {0.025, 0.015}) {
      X_CM = AlignPoints(model, X_CM, view, label, kFinePoints, 5, gate);
      keep_better(X_CM, kFinePoints, &guess);
    }
    guess.quality *= 0.4 + 0.6 * ColorShare(model, guess.X_CM, view, label);
  }
  return KeepDistinct(std::move(guesses), model, 0.01, 0.12, count);
}

}  // namespace secondlook::perception
