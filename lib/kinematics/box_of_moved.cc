#include "lib/kinematics/box_of_moved.h"

#include <cmath>
#include <variant>
#include <vector>

namespace secondlook::kinematics {
namespace {

using Eigen::Vector3d;

// How far a shape reaches from its origin along each axis of a frame A, in which it is turned by
// `R_AS`.

Vector3d Reach(const geometry::Box& box, const Eigen::Matrix3d& R_AS) {
  return R_AS.cwiseAbs() * (0.5 * box.size);
}

Vector3d Reach(const geometry::Cylinder& cylinder, const Eigen::Matrix3d& R_AS) {
  const Eigen::Array3d along = R_AS.col(2).array().abs();
  const Eigen::Array3d across = (1.0 - along.square()).max(0.0).sqrt();
  return 0.5 * cylinder.height * along + cylinder.radius * across;
}

Vector3d Reach(const geometry::Sphere& sphere, const Eigen::Matrix3d& /*R_AS*/) {
  return Vector3d::Constant(sphere.radius);
}

}  // namespace

Eigen::AlignedBox3d BoxOfMoved(const Chain& chain, const Eigen::VectorXd& q) {
  const std::vector<Link>& links = chain.model().links;
  const std::vector<Pose> X_BL = chain.LinkPoses(q);
  Eigen::AlignedBox3d box_B;
  for (int l = 0; l < static_cast<int>(links.size()); ++l) {
    if (!chain.Moves(l)) continue;
    box_B.extend(Vector3d(X_BL[l].translation()));
    for (const geometry::PlacedShape& part : links[l].body) {
      const Pose X_BS = X_BL[l] * part.X_AS;
      const Vector3d reach =
          std::visit([&](const auto& shape) { return Reach(shape, X_BS.linear()); }, part.shape);
      box_B.extend(Vector3d(X_BS.translation() - reach));
      box_B.extend(Vector3d(X_BS.translation() + reach));
    }
  }
  return box_B;
}

}  // namespace secondlook::kinematics
