#include "lib/perception/equivalent_pose.h"

#include <cmath>

namespace secondlook::perception {
namespace {

/// The angle about the unit vector `axis` of the turn about it that comes nearest to `R`.
double AngleAbout(const Eigen::Vector3d& axis, const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return 2.0 * std::atan2(q.vec().dot(axis), q.w());
}

}  // namespace

Pose NearestEquivalent(const Pose& X_CA, const Pose& X_CB, const Symmetry& symmetry, bool color) {
  const bool turns = symmetry.axis && (!color || symmetry.axis_keeps_color);
  Pose nearest = X_CB;
  double least = RotationDistance(X_CA.linear(), X_CB.linear());
  for (const SymmetryMotion& motion : symmetry.motions) {
    if (color && !motion.keeps_color) continue;
    Pose X_CE = X_CB * motion.X_MS;
    if (turns) {
      const Eigen::Matrix3d R_EA = X_CE.linear().transpose() * X_CA.linear();
      X_CE = X_CE * TurnAbout(*symmetry.axis, AngleAbout(symmetry.axis->direction, R_EA));
    }
    const double rotation = RotationDistance(X_CA.linear(), X_CE.linear());
    if (rotation >= least) continue;
    least = rotation;
    nearest = X_CE;
  }
  return nearest;
}

}  // namespace secondlook::perception
