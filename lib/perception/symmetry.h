#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/mesh.h"

namespace secondlook::perception {

/// A line about which a model may be turned, in M.
struct Axis {
  Eigen::Vector3d point;      ///< A point of the line [m].
  Eigen::Vector3d direction;  ///< Unit.
};

/// A motion of M that leaves the model's shape as it is, and perhaps its colour too.
struct SymmetryMotion {
  Pose X_MS{Pose::Identity()};  ///< A model at X_CM * X_MS has the same shape as one at X_CM.
  bool keeps_color{};           ///< It looks the same too.
};

/// The rotations that leave a model unchanged. With a continuous axis the whole group is the
/// products of `motions` with the turns about the axis.
struct Symmetry {
  std::vector<SymmetryMotion> motions;  ///< At least the identity, which comes first.
  std::optional<Axis> axis;             ///< Any turn about it leaves the shape unchanged.
  bool axis_keeps_color{};              ///< ... and the colour: no view tells the turn.
};

/// How detection decides that a turned model is the same.
struct SymmetryOptions {
  double mean_distance = 0.008;   ///< Of the turned surface to the model, shares of its diameter…
  double worst_distance = 0.025;  ///< …in the mean, and for the 97th hundredth.
  double color_distance = 0.08;   ///< Mean difference of RGB in [0, 1] at the nearest points.
};

/// The turn by `angle` [rad] about `axis`, as a motion of M.
Pose TurnAbout(const Axis& axis, double angle);

/// Finds the rotations about lines through the centre of the surface that leave `mesh` unchanged:
/// the principal axes and the axes of M, each tried for any turn and for one 2nd, 3rd, 4th, 5th,
/// 6th and 8th of a whole turn. Drawn points are compared with the nearest points of the surface,
/// so a mesh need not be clean.
/// @pre !mesh.empty().
Symmetry FindSymmetry(const geometry::Mesh& mesh, const SymmetryOptions& options = {});

/// How far apart two poses of one model are, up to its symmetry.
struct PoseDistance {
  double translation{};  ///< Of the centre [m].
  double rotation{};     ///< [rad], in [0, pi].
};

/// The least rotation between X_CA and X_CB over the symmetry; translation is that of the point
/// `center_M`, which no motion of the symmetry moves by much. Only motions that keep the colour
/// count when `color` is true.
PoseDistance DistanceUpToSymmetry(const Pose& X_CA, const Pose& X_CB, const Symmetry& symmetry,
                                  const Eigen::Vector3d& center_M, bool color);

}  // namespace secondlook::perception
