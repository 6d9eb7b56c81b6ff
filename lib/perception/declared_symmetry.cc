#include "lib/perception/declared_symmetry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/geometry/kd_tree.h"
#include "lib/geometry/sampling.h"

namespace secondlook::perception {
namespace {

constexpr int kDense = 4000;            // points that stand for the surface
constexpr int kProbes = 300;            // points that are turned
constexpr double kMostDistance = 0.05;  // of the diameter, between turned point and surface
constexpr double kSameTurn = 0.15;      // [rad]
constexpr int kTriedTurns = 7;          // of an axis that any turn is declared about

/// How far turned points lie from the surface.
class TurnedSurface {
 public:
  explicit TurnedSurface(const geometry::Mesh& mesh) {
    Rng rng(1);
    std::vector<Eigen::Vector3d> dense;
    for (const geometry::MeshSample& sample : geometry::SampleSurface(mesh, kDense, &rng)) {
      dense.push_back(sample.surface.point.cast<double>());
    }
    tree_ = geometry::KdTree(std::move(dense));
    for (const geometry::MeshSample& sample : geometry::SampleSurface(mesh, kProbes, &rng)) {
      probes_.push_back(sample.surface.point.cast<double>());
    }
  }

  /// The 97th hundredth of the distances of the turned points [m].
  double DistanceAfter(const Pose& X_MS) const {
    std::vector<double> distances;
    for (const Eigen::Vector3d& probe : probes_) {
      const auto nearest = tree_.Nearest(X_MS * probe, std::numeric_limits<double>::max());
      distances.push_back(std::sqrt(nearest->squared_distance));
    }
    const auto rank = static_cast<std::ptrdiff_t>(0.97 * kProbes);
    std::nth_element(distances.begin(), distances.begin() + rank, distances.end());
    return distances[static_cast<std::size_t>(rank)];
  }

 private:
  geometry::KdTree tree_{{}};
  std::vector<Eigen::Vector3d> probes_;
};

/// The turns that stand for a declared symmetry when its shape is checked, and, of a fold, all that
/// there are but the identity.
std::vector<Pose> TurnsOf(const world::DeclaredSymmetry& declared, const Axis& axis) {
  const int steps = declared.fold > 0 ? declared.fold : kTriedTurns;
  std::vector<Pose> turns;
  for (int k = 1; k < steps; ++k) {
    turns.push_back(TurnAbout(axis, 2.0 * std::numbers::pi * k / steps));
  }
  return turns;
}

void AddMotion(const SymmetryMotion& motion, Symmetry* symmetry) {
  for (SymmetryMotion& known : symmetry->motions) {
    if (RotationDistance(known.X_MS.linear(), motion.X_MS.linear()) < kSameTurn) {
      known.keeps_color = known.keeps_color || motion.keeps_color;
      return;
    }
  }
  symmetry->motions.push_back(motion);
}

}  // namespace

void Declare(const std::vector<world::DeclaredSymmetry>& declared, const geometry::Mesh& mesh,
             Symmetry* symmetry) {
  if (declared.empty()) return;
  const TurnedSurface surface(mesh);
  const double most = kMostDistance * geometry::Diameter(mesh);
  for (const world::DeclaredSymmetry& one : declared) {
    const Axis axis{geometry::Bounds(mesh).center().cast<double>(), one.direction_M};
    const std::vector<Pose> turns = TurnsOf(one, axis);
    for (const Pose& X_MS : turns) {
      const double distance = surface.DistanceAfter(X_MS);
      if (distance > most) {
        Throw<InvalidArgument>(
            "its declared symmetry {} does not leave its shape: turned, 3 % of it lies {:.1f} mm "
            "or more away from it, and {:.1f} mm are allowed",
            world::Text(one), 1000.0 * distance, 1000.0 * most);
      }
    }
    if (one.fold == 0) {
      symmetry->axis = axis;
      symmetry->axis_keeps_color = true;
      continue;
    }
    const std::vector<SymmetryMotion> before = symmetry->motions;
    for (const Pose& X_MS : turns) {
      for (const SymmetryMotion& motion : before) {
        AddMotion({X_MS * motion.X_MS, motion.keeps_color}, symmetry);
      }
    }
  }
}

}  // namespace secondlook::perception
