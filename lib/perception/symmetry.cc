#include "lib/perception/symmetry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

#include "lib/common/rng.h"
#include "lib/geometry/kd_tree.h"
#include "lib/geometry/sampling.h"

namespace secondlook::perception {
namespace {

constexpr int kDense = 4000;  // points that stand for the surface
constexpr int kProbes = 300;  // points that are turned

/// The surface as points, to which turned points are compared.
struct Surface {
  geometry::KdTree tree;
  std::vector<Eigen::Vector3f> colors;  // by point of the tree
};

struct Difference {
  double mean;   // [m]
  double worst;  // [m], 97th hundredth
  double color;  // mean absolute difference of RGB
};

geometry::Neighbour NearestOf(const geometry::KdTree& tree, const Eigen::Vector3d& query) {
  return *tree.Nearest(query, std::numeric_limits<double>::max());
}

Difference Compare(const Surface& surface, const std::vector<Eigen::Vector3f>& probes,
                   const std::vector<Eigen::Vector3f>& colors, const Pose& X_MS) {
  std::vector<double> distances;
  distances.reserve(probes.size());
  double sum = 0.0;
  double color = 0.0;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const geometry::Neighbour nearest = NearestOf(surface.tree, X_MS * probes[i].cast<double>());
    const double distance = std::sqrt(nearest.squared_distance);
    sum += distance;
    distances.push_back(distance);
    color +=
        (surface.colors[static_cast<std::size_t>(nearest.index)] - colors[i]).cwiseAbs().mean();
  }
  const auto count = static_cast<double>(probes.size());
  const auto rank = static_cast<std::ptrdiff_t>(0.97 * count);
  std::nth_element(distances.begin(), distances.begin() + rank, distances.end());
  return {sum / count, distances[static_cast<std::size_t>(rank)], color / count};
}

/// Mean colour of the points around each, so that fine print does not decide.
std::vector<Eigen::Vector3f> Smooth(const geometry::KdTree& tree,
                                    const std::vector<Eigen::Vector3f>& points,
                                    const std::vector<Eigen::Vector3f>& colors, double radius) {
  std::vector<Eigen::Vector3f> smooth;
  smooth.reserve(points.size());
  const auto r = static_cast<float>(radius);
  // The six neighbours at `radius` along the axes, by the tree, and the point itself.
  for (const Eigen::Vector3f& point : points) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      for (const float sign : {-1.0F, 0.0F, 1.0F}) {
        const Eigen::Vector3f query = point + sign * r * Eigen::Vector3f::Unit(axis);
        sum += colors[static_cast<std::size_t>(NearestOf(tree, query.cast<double>()).index)];
      }
    }
    smooth.push_back(sum / 9.0F);
  }
  return smooth;
}

/// Lines along the axes of M and the principal axes, through the middle of the bounding box and the
/// mean of the surface. Hidden surfaces inside move the mean, a handle moves the box.
std::vector<Axis> CandidateAxes(const std::vector<Eigen::Vector3f>& points,
                                const Eigen::Vector3d& middle, double same_line) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : points) mean += p.cast<double>();
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3d d = p.cast<double>() - mean;
    scatter += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  std::vector<Axis> axes;
  const auto add = [&](const Eigen::Vector3d& point, const Eigen::Vector3d& direction) {
    const bool known = std::any_of(axes.begin(), axes.end(), [&](const Axis& axis) {
      return std::abs(axis.direction.dot(direction)) > std::cos(0.03) &&
             (axis.point - point).cross(direction).norm() < same_line;
    });
    if (!known) axes.push_back({point, direction});
  };
  for (const Eigen::Vector3d& point : {middle, mean}) {
    for (int i = 0; i < 3; ++i) add(point, Eigen::Vector3d::Unit(i));
    for (int i = 0; i < 3; ++i) add(point, eigen.eigenvectors().col(i));
  }
  return axes;
}

}  // namespace

Pose TurnAbout(const Axis& axis, double angle) {
  Pose X = Pose::Identity();
  X.linear() = Eigen::AngleAxisd(angle, axis.direction).toRotationMatrix();
  X.translation() = axis.point - X.linear() * axis.point;
  return X;
}

Symmetry FindSymmetry(const geometry::Mesh& mesh, const SymmetryOptions& options) {
  constexpr double kPi = std::numbers::pi;
  Rng rng(1);
  std::vector<Eigen::Vector3f> dense;
  std::vector<Eigen::Vector3d> dense_points;
  std::vector<Eigen::Vector3f> dense_colors;
  for (const geometry::MeshSample& sample : geometry::SampleSurface(mesh, kDense, &rng)) {
    dense.push_back(sample.surface.point);
    dense_points.push_back(sample.surface.point.cast<double>());
    dense_colors.push_back(geometry::ColorAt(mesh, sample.triangle, sample.weights));
  }
  std::vector<Eigen::Vector3f> probes;
  for (const geometry::MeshSample& sample : geometry::SampleSurface(mesh, kProbes, &rng)) {
    probes.push_back(sample.surface.point);
  }
  const double diameter = geometry::Diameter(mesh);
  Surface surface{geometry::KdTree(std::move(dense_points)), {}};
  surface.colors = Smooth(surface.tree, dense, dense_colors, 0.02 * diameter);
  std::vector<Eigen::Vector3f> probe_colors;
  for (const Eigen::Vector3f& probe : probes) {
    probe_colors.push_back(
        surface
            .colors[static_cast<std::size_t>(NearestOf(surface.tree, probe.cast<double>()).index)]);
  }
  const Difference floor = Compare(surface, probes, probe_colors, Pose::Identity());

  const auto same_shape = [&](const Difference& d) {
    return d.mean - floor.mean < options.mean_distance * diameter &&
           d.worst - floor.worst < options.worst_distance * diameter;
  };
  const auto same_color = [&](const Difference& d) {
    return d.color - floor.color < options.color_distance;
  };

  Symmetry symmetry;
  symmetry.motions.push_back({Pose::Identity(), true});
  const std::vector<Axis> axes =
      CandidateAxes(dense, geometry::Bounds(mesh).center(), 0.01 * diameter);
  for (const Axis& axis : axes) {
    bool shape = true;
    bool color = true;
    for (const double angle : {0.4, 1.0, 1.7, 2.3, kPi, 3.9, 4.6, 5.5}) {
      const Difference d = Compare(surface, probes, probe_colors, TurnAbout(axis, angle));
      shape = shape && same_shape(d);
      color = color && same_color(d);
      if (!shape) break;
    }
    if (!shape) continue;
    symmetry.axis = axis;
    symmetry.axis_keeps_color = color;
    break;
  }
  const auto add = [&](const Pose& X_MS) {
    constexpr double kSameTurn = 0.15;  // [rad]
    const bool known =
        std::any_of(symmetry.motions.begin(), symmetry.motions.end(), [&](const SymmetryMotion& m) {
          return RotationDistance(m.X_MS.linear(), X_MS.linear()) < kSameTurn;
        });
    if (known) return;
    const Difference d = Compare(surface, probes, probe_colors, X_MS);
    if (same_shape(d)) symmetry.motions.push_back({X_MS, same_color(d)});
  };
  for (const Axis& axis : axes) {
    const bool along =
        symmetry.axis && std::abs(symmetry.axis->direction.dot(axis.direction)) > std::cos(0.1);
    if (along) continue;
    for (const int fold : {8, 6, 5, 4, 3, 2}) {
      const Pose X_MS = TurnAbout(axis, 2.0 * kPi / fold);
      if (!same_shape(Compare(surface, probes, probe_colors, X_MS))) continue;
      for (int k = 1; k < fold; ++k) add(TurnAbout(axis, 2.0 * kPi * k / fold));
      break;
    }
    // Beside a continuous axis one flip makes the whole group.
    if (symmetry.axis && symmetry.motions.size() > 1) return symmetry;
  }
  // The products of two motions belong to the group: half turns about diagonals, for one.
  constexpr std::size_t kMostMotions = 24;  // the rotations of a cube
  for (std::size_t i = 1; i < symmetry.motions.size(); ++i) {
    for (std::size_t k = 1; k <= i && symmetry.motions.size() < kMostMotions; ++k) {
      const Pose X_product = symmetry.motions[i].X_MS * symmetry.motions[k].X_MS;
      add(X_product);
    }
  }
  return symmetry;
}

PoseDistance DistanceUpToSymmetry(const Pose& X_CA, const Pose& X_CB, const Symmetry& symmetry,
                                  const Eigen::Vector3d& center_M, bool color) {
  PoseDistance distance{(X_CA * center_M - X_CB * center_M).norm(), 2.0 * std::numbers::pi};
  const bool turns = symmetry.axis && (!color || symmetry.axis_keeps_color);
  for (const SymmetryMotion& motion : symmetry.motions) {
    if (color && !motion.keeps_color) continue;
    const Eigen::Matrix3d R_CB = X_CB.linear() * motion.X_MS.linear();
    double rotation = 0.0;
    if (turns) {
      const Eigen::Vector3d& direction = symmetry.axis->direction;
      const double cosine = (X_CA.linear() * direction).dot(R_CB * direction);
      rotation = std::acos(std::clamp(cosine, -1.0, 1.0));
    } else {
      rotation = RotationDistance(X_CA.linear(), R_CB);
    }
    distance.rotation = std::min(distance.rotation, rotation);
  }
  return distance;
}

}  // namespace secondlook::perception
