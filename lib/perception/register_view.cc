#include "lib/perception/register_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/geometry/kd_tree.h"
#include "lib/geometry/normals.h"
#include "lib/geometry/point_image.h"
#include "lib/geometry/point_to_plane.h"
#include "lib/geometry/sampling.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;
using geometry::PointPlanePair;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kDegree = std::numbers::pi / 180.0;
/// Neighbours tried until one has a compatible normal.
constexpr int kNeighbours = 6;
/// A step below these ends the iterations once the gate is narrow.
constexpr double kSmallMove = 2e-5;  ///< [m]
constexpr double kSmallTurn = 2e-5;  ///< [rad]

std::array<int, 3> CellOf(const Vector3d& p, double spacing) {
  const Eigen::Vector3i cell = (p / spacing).array().floor().cast<int>();
  return {cell.x(), cell.y(), cell.z()};
}

/// Variance of the distance along `normal_W` of a point at `arm_W` from the origin of a frame whose
/// pose is known up to `covariance`.
double VarianceAt(const PoseCovariance& covariance, const Vector3d& arm_W,
                  const Vector3d& normal_W) {
  Vector6 jacobian;
  jacobian << arm_W.cross(normal_W), normal_W;
  return std::max(0.0, jacobian.dot(covariance * jacobian));
}

/// The small error that takes `X_WA` to `X_WB`.
Vector6 Between(const Pose& X_WA, const Pose& X_WB) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(X_WB.linear() * X_WA.linear().transpose()));
  Vector6 error;
  error << turn.angle() * turn.axis(), X_WB.translation() - X_WA.translation();
  return error;
}

/// A map to register to, ready for queries.
struct Target {
  std::vector<SurfacePoint> points_W;
  geometry::KdTree tree;

  explicit Target(const ReferenceCloud& reference)
      : points_W(reference.Points()), tree([this] {
          std::vector<Vector3d> p;
          for (const SurfacePoint& point : points_W) p.push_back(point.p_AP);
          return p;
        }()) {}

  /// The nearest point within `gate` whose normal makes an angle with `normal_W` whose cosine is at
  /// least `min_cosine`; null when there is none.
  const SurfacePoint* Match(const Vector3d& p_W, const Vector3d& normal_W, double gate,
                            double min_cosine) const {
    for (const geometry::Neighbour& neighbour : tree.Nearest(p_W, kNeighbours)) {
      if (neighbour.squared_distance > gate * gate) break;
      const SurfacePoint& point = points_W[neighbour.index];
      if (point.normal_A.dot(normal_W) >= min_cosine) return &point;
    }
    return nullptr;
  }
};

/// The pairs at a pose, with Tukey's weights for the gate.
std::vector<PointPlanePair> FindPairs(const std::vector<SurfacePoint>& points_C,
                                      const Target& target, const Pose& X_WC, double gate,
                                      const RegisterConfig& config) {
  const double min_cosine = std::cos(config.max_normal_angle_deg * kDegree);
  std::vector<PointPlanePair> pairs;
  for (const SurfacePoint& point_C : points_C) {
    const Vector3d p_W = X_WC * point_C.p_AP;
    const Vector3d normal_W = X_WC.linear() * point_C.normal_A;
    const SurfacePoint* match = target.Match(p_W, normal_W, gate, min_cosine);
    if (match == nullptr) continue;
    const double residual = match->normal_A.dot(match->p_AP - p_W);
    if ((match->p_AP - p_W - residual * match->normal_A).norm() > config.max_slide_m) continue;
    const double tukey = 1.0 - (residual / gate) * (residual / gate);
    if (tukey <= 0.0) continue;
    const double variance = point_C.sigma * point_C.sigma + match->sigma * match->sigma;
    pairs.push_back({p_W, match->p_AP, match->normal_A, tukey * tukey / variance});
  }
  return pairs;
}

double Rms(const std::vector<PointPlanePair>& pairs) {
  double sum = 0.0;
  double weights = 0.0;
  for (const PointPlanePair& pair : pairs) {
    const double residual = pair.normal_A.dot(pair.p_AQ - pair.p_AP);
    sum += pair.weight * residual * residual;
    weights += pair.weight;
  }
  return weights > 0.0 ? std::sqrt(sum / weights) : 0.0;
}

/// The point of the plane's edge beside a pixel of the plane: above its upright side where that is
/// seen, else halfway to the next pixel that sees past it.
std::optional<Vector3d> EdgePoint(const geometry::PointImage& image,
                                  const geometry::CameraModel& camera,
                                  const world::SupportPlane& plane_C, int u, int v,
                                  const RegisterConfig& config) {
  static constexpr std::array<std::array<int, 2>, 4> kWays = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  const Vector3d from_C = image.points_C[v * image.width + u].cast<double>();
  for (const auto& [du, dv] : kWays) {
    bool beside = true;  // nothing but pixels without return between
    for (int gap = 1; gap <= config.edge_gap_px; ++gap) {
      const int to_u = u + gap * du;
      const int to_v = v + gap * dv;
      if (to_u < 0 || to_v < 0 || to_u >= image.width || to_v >= image.height) break;
      const Vector3d p_CP = image.points_C[to_v * image.width + to_u].cast<double>();
      if (!p_CP.allFinite()) continue;
      const double height = plane_C.HeightOf(p_CP);
      if (height > -config.edge_drop_m) {
        beside = false;
        continue;
      }
      const Vector3d above_C = p_CP - height * plane_C.normal_A;
      if ((above_C - from_C).norm() < config.edge_face_m) return above_C;  // an upright side
      if (!beside) break;
      const Vector3d ray_C = camera.Ray(u + 0.5 * gap * du, v + 0.5 * gap * dv);
      const double depth = plane_C.offset / plane_C.normal_A.dot(ray_C);
      if (depth > 0.0) return ray_C * depth;
      break;
    }
  }
  return std::nullopt;
}

/// The plane's edge as points of an upright surface that faces away from `middle_C`.
std::vector<SurfacePoint> EdgeSurface(const std::vector<Vector3d>& edge_C,
                                      const world::SupportPlane& plane_C, const Vector3d& middle_C,
                                      const RegisterConfig& config) {
  constexpr int kMinPoints = 5;
  constexpr double kMaxWidth = 0.2;  // of the edge's length, or it is a corner or a crumb
  const geometry::KdTree tree(edge_C);
  std::vector<SurfacePoint> surface;
  for (const Vector3d& p_CP : edge_C) {
    const std::vector<geometry::Neighbour> near = tree.Within(p_CP, config.edge_radius_m);
    if (static_cast<int>(near.size()) < kMinPoints) continue;
    Vector3d mean = Vector3d::Zero();
    for (const geometry::Neighbour& neighbour : near) mean += edge_C[neighbour.index];
    mean /= static_cast<double>(near.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const geometry::Neighbour& neighbour : near) {
      const Vector3d arm = edge_C[neighbour.index] - mean;
      scatter += arm * arm.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
    const double width = std::sqrt(std::max(0.0, eigen.eigenvalues()[1]));
    if (width > kMaxWidth * std::sqrt(eigen.eigenvalues()[2])) continue;
    Vector3d normal_C = Vector3d(eigen.eigenvectors().col(2)).cross(plane_C.normal_A).normalized();
    if (normal_C.dot(mean - middle_C) < 0.0) normal_C = -normal_C;
    surface.push_back({p_CP + normal_C * normal_C.dot(mean - p_CP), normal_C, config.edge_sigma_m});
  }
  return surface;
}

void CheckPose(const Pose& X, const char* name) {
  if (!IsValid(X)) Throw<InvalidArgument>("registration: {} is not finite and rigid", name);
}

}  // namespace

void RegisterConfig::Validate() const {
  CheckRange(base_m, 1e-4, 1.0, "base_m");
  CheckRange(base_yaw_deg, 1e-3, 30.0, "base_yaw_deg");
  CheckRange(extrinsics_m, 1e-4, 1.0, "extrinsics_m");
  CheckRange(extrinsics_deg, 1e-3, 30.0, "extrinsics_deg");
  CheckRange(plane_spacing_m, 0.001, 1.0, "plane_spacing_m");
  CheckRange(object_spacing_m, 0.001, 1.0, "object_spacing_m");
  CheckRange(plane_height_m, 0.0, 0.2, "plane_height_m");
  CheckRange(max_height_m, plane_height_m, 5.0, "max_height_m");
  CheckRange(edge_face_m, 0.0, 1.0, "edge_face_m");
  CheckRange(edge_drop_m, plane_height_m, 1.0, "edge_drop_m");
  CheckRange(edge_gap_px, 0, 100, "edge_gap_px");
  CheckRange(edge_radius_m, 0.001, 1.0, "edge_radius_m");
  CheckRange(edge_sigma_m, 1e-4, 1.0, "edge_sigma_m");
  CheckRange(plane_margin_m, 0.0, 1.0, "plane_margin_m");
  CheckRange(last_gate_m, 0.001, 1.0, "last_gate_m");
  CheckRange(first_gate_m, last_gate_m, 1.0, "first_gate_m");
  CheckRange(max_normal_angle_deg, 1.0, 90.0, "max_normal_angle_deg");
  CheckRange(max_slide_m, 0.0, 1.0, "max_slide_m");
  CheckRange(iterations, 1, 1000, "iterations");
  CheckRange(min_constraint, 0.0, 1.0, "min_constraint");
  CheckRange(min_pairs, 6, 1e6, "min_pairs");
  CheckRange(common_shift_m, 0.0, 0.1, "common_shift_m");
  CheckRange(pairs_per_independent, 1.0, 1e6, "pairs_per_independent");
  CheckRange(max_sigmas, 0.1, 100.0, "max_sigmas");
}

PoseCovariance NominalCovariance(const RegisterConfig& config, const Vector3d& p_CB_W) {
  const double extrinsics = config.extrinsics_deg * kDegree;
  PoseCovariance covariance = PoseCovariance::Zero();
  // Twice that of one view; four times for what is fixed to the camera, since from the other side
  // it errs to the other side.
  covariance.diagonal() << Vector3d::Constant(4.0 * extrinsics * extrinsics),
      Vector3d::Constant(4.0 * config.extrinsics_m * config.extrinsics_m);
  covariance.block<2, 2>(3, 3) += 2.0 * config.base_m * config.base_m * Eigen::Matrix2d::Identity();
  // The heading turns the camera about the base's origin.
  Vector6 by_yaw;
  by_yaw << Vector3d::UnitZ(), Vector3d::UnitZ().cross(-p_CB_W);
  const double yaw = config.base_yaw_deg * kDegree;
  covariance += 2.0 * yaw * yaw * by_yaw * by_yaw.transpose();
  return covariance;
}

PoseCovariance CovarianceBeside(const RegisterConfig& config, const PoseCovariance& covariance,
                                const Vector3d& p_OC_W) {
  PoseCovariance extrinsics = PoseCovariance::Zero();
  extrinsics.diagonal() << Vector3d::Constant(std::pow(config.extrinsics_deg * kDegree, 2)),
      Vector3d::Constant(std::pow(config.extrinsics_m, 2));
  PoseCovariance lever = PoseCovariance::Identity();  // t_C = t_O + r x p_OC
  for (int i = 0; i < 3; ++i) {
    lever.block<3, 1>(3, i) = Vector3d::Unit(i).cross(p_OC_W);
  }
  return lever * (covariance + extrinsics) * lever.transpose() + extrinsics;
}

std::vector<SurfacePoint> ViewPoints(const cv::Mat& depth, const geometry::CameraModel& camera,
                                     const world::SupportPlane& plane_C,
                                     const RegisterConfig& config) {
  const geometry::PointImage image = geometry::Deproject(depth, camera);
  enum Kind { kObject, kPlane, kEdge };
  std::set<std::array<int, 4>> taken;  // a cell a kind
  const auto is_new = [&](Kind kind, const Vector3d& p_CP, double spacing) {
    const auto [x, y, z] = CellOf(p_CP, spacing);
    return taken.insert({kind, x, y, z}).second;
  };
  std::vector<SurfacePoint> points;
  std::vector<Vector3d> edge_C;
  Vector3d middle_C = Vector3d::Zero();
  int on_plane = 0;
  for (int i = 0; i < image.width * image.height; ++i) {
    const Vector3d p_CP = image.points_C[i].cast<double>();
    if (!p_CP.allFinite()) continue;
    const double height = plane_C.HeightOf(p_CP);
    if (height < -config.plane_height_m || height > config.max_height_m) continue;
    if (!plane_C.Covers(p_CP, config.plane_margin_m)) continue;
    const bool is_plane = height < config.plane_height_m;
    if (is_plane) {
      const auto edge = EdgePoint(image, camera, plane_C, i % image.width, i / image.width, config);
      if (edge && is_new(kEdge, *edge, config.object_spacing_m)) edge_C.push_back(*edge);
      middle_C += p_CP;
      ++on_plane;
    }
    if (!is_new(is_plane ? kPlane : kObject, p_CP,
                is_plane ? config.plane_spacing_m : config.object_spacing_m)) {
      continue;
    }
    const std::optional<geometry::OrientedPoint> local =
        geometry::FitLocalPlane(depth, cv::Mat(), camera, i);
    if (!local) continue;
    points.push_back({local->point.cast<double>(), local->normal.cast<double>().normalized(),
                      geometry::DepthSigma(p_CP.z())});
  }
  if (on_plane == 0) return points;
  const std::vector<SurfacePoint> edge =
      EdgeSurface(edge_C, plane_C, middle_C / static_cast<double>(on_plane), config);
  points.insert(points.end(), edge.begin(), edge.end());
  return points;
}

ReferenceCloud::ReferenceCloud(double cell) : cell_(cell) {
  if (!(cell > 0.0)) Throw<InvalidArgument>("reference cloud: a cell of {} m", cell);
}

void ReferenceCloud::Add(const SurfacePoint& point_W) {
  const auto [x, y, z] = CellOf(point_W.p_AP, cell_);
  Eigen::Index axis = 0;
  point_W.normal_A.cwiseAbs().maxCoeff(&axis);
  const int direction = 2 * static_cast<int>(axis) + (point_W.normal_A[axis] < 0.0 ? 1 : 0);
  Sum& sum = cells_[{x, y, z, direction}];
  const double weight = 1.0 / (point_W.sigma * point_W.sigma);
  sum.point += weight * point_W.p_AP;
  sum.normal += weight * point_W.normal_A;
  sum.sigma = sum.weight > 0.0 ? std::min(sum.sigma, point_W.sigma) : point_W.sigma;
  sum.weight += weight;
}

void ReferenceCloud::AddView(const std::vector<SurfacePoint>& points_C, const Pose& X_WC,
                             const PoseCovariance& covariance) {
  CheckPose(X_WC, "the pose X_WC of a view");
  if (!covariance.allFinite()) {
    Throw<InvalidArgument>("registration: the covariance of X_WC is not finite");
  }
  for (const SurfacePoint& point_C : points_C) {
    const Vector3d p_W = X_WC * point_C.p_AP;
    const Vector3d normal_W = X_WC.linear() * point_C.normal_A;
    const double variance =
        point_C.sigma * point_C.sigma + VarianceAt(covariance, p_W - X_WC.translation(), normal_W);
    Add({p_W, normal_W, std::sqrt(variance)});
  }
}

void ReferenceCloud::AddModel(const geometry::Mesh& mesh, const Pose& X_WM, double sigma) {
  CheckPose(X_WM, "the pose X_WM of a model");
  if (mesh.empty()) Throw<InvalidArgument>("registration: the model's mesh has no triangle");
  if (!(sigma > 0.0)) Throw<InvalidArgument>("registration: a model with sigma = {} m", sigma);
  double area = 0.0;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    const Eigen::Vector3f a = mesh.vertices[triangle[0]];
    const Eigen::Vector3f normal =
        (mesh.vertices[triangle[1]] - a).cross(mesh.vertices[triangle[2]] - a);
    area += 0.5 * normal.norm();
  }
  Rng rng(ForkSeed(0, "reference cloud"));  // where exactly the samples lie does not matter
  const int count = 1 + static_cast<int>(area / (cell_ * cell_));
  for (const geometry::MeshSample& sample : geometry::SampleSurface(mesh, count, &rng)) {
    Add({X_WM * sample.surface.point.cast<double>(),
         X_WM.linear() * sample.surface.normal.cast<double>().normalized(), sigma});
  }
}

void ReferenceCloud::Remove(const Eigen::AlignedBox3d& box_W) {
  std::erase_if(cells_, [&](const auto& entry) {
    return box_W.contains(Vector3d(entry.second.point / entry.second.weight));
  });
}

std::vector<SurfacePoint> ReferenceCloud::Points() const {
  std::vector<SurfacePoint> points;
  points.reserve(cells_.size());
  for (const auto& [key, sum] : cells_) {
    points.push_back({sum.point / sum.weight, sum.normal.normalized(), sum.sigma});
  }
  return points;
}

ViewRegistration RegisterView(const std::vector<SurfacePoint>& points_C,
                              const ReferenceCloud& reference, const Pose& nominal_X_WC,
                              const PoseCovariance& covariance, const RegisterConfig& config) {
  config.Validate();
  CheckPose(nominal_X_WC, "the nominal pose X_WC");
  if (reference.empty()) Throw<InvalidArgument>("registration: the reference cloud is empty");
  const Eigen::LLT<PoseCovariance> prior(covariance);
  if (!covariance.allFinite() || prior.info() != Eigen::Success) {
    Throw<InvalidArgument>("registration: the covariance of X_WC is not positive definite");
  }
  ViewRegistration result;
  result.X_WC = nominal_X_WC;
  result.covariance = covariance;

  const PoseCovariance prior_information = prior.solve(PoseCovariance::Identity());
  const Target target(reference);
  // The gate reaches its last width after two thirds of the iterations.
  const double shrink = std::pow(config.last_gate_m / config.first_gate_m,
                                 1.0 / std::max(1.0, config.iterations / 1.5));
  Pose X_WC = nominal_X_WC;
  double gate = config.first_gate_m;
  std::vector<PointPlanePair> pairs;
  geometry::PointPlaneStep step;
  double shift = 0.0;  // that all pairs may have in common
  const auto weigh = [&] {
    return geometry::SolvePointToPlane(
        pairs, {X_WC.translation(), Between(X_WC, nominal_X_WC), prior_information, shift},
        config.min_constraint);
  };
  for (int i = 0; i < config.iterations; ++i) {
    pairs = FindPairs(points_C, target, X_WC, gate, config);
    step = weigh();
    X_WC = step.X * X_WC;
    const bool settled =
        (step.X * X_WC.translation() - X_WC.translation()).norm() < kSmallMove &&
        RotationDistance(step.X.linear(), Eigen::Matrix3d::Identity()) < kSmallTurn;
    if (settled && gate <= config.last_gate_m) break;
    gate = std::max(config.last_gate_m, gate * shrink);
  }
  // At last all pairs may be off together …
  shift = config.common_shift_m;
  step = weigh();
  X_WC = step.X * X_WC;
  // … and they hold the pose by what they are worth together.
  for (PointPlanePair& pair : pairs) pair.weight /= config.pairs_per_independent;
  step = weigh();
  result.constrained = step.constrained;
  result.pairs = static_cast<int>(pairs.size());
  result.rms = Rms(pairs);
  if (result.pairs < config.min_pairs || result.constrained == 0) {
    result.reason = fmt::format(
        "{} pairs within {:.0f} mm of {} points hold {} directions; at least {} pairs are wanted",
        result.pairs, 1000.0 * config.last_gate_m, points_C.size(), result.constrained,
        config.min_pairs);
    return result;
  }
  result.sigmas = step.sigmas;
  if (result.sigmas > config.max_sigmas) {
    const Vector6 moved = Between(nominal_X_WC, X_WC);
    result.reason = fmt::format(
        "the pairs are {:.1f} sigma from the nominal pose (the best of both is {:.0f} mm, {:.1f} "
        "deg away); at most {:.1f} are believed",
        result.sigmas, 1000.0 * moved.tail<3>().norm(), moved.head<3>().norm() / kDegree,
        config.max_sigmas);
    return result;
  }
  result.accepted = true;
  result.X_WC = X_WC;
  const PoseCovariance information =
      prior_information +
      geometry::InformationAbout(X_WC.translation(), step.centroid_A, step.information);
  result.covariance = information.llt().solve(PoseCovariance::Identity());
  return result;
}

}  // namespace secondlook::perception
