#include "lib/world/support_plane.h"

#include <algorithm>
#include <cmath>

namespace secondlook::world {

bool SupportPlane::Covers(const Eigen::Vector3d& p_AQ, double margin) const {
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d edge = corners_A[(i + 1) % 4] - corners_A[i];
    const Eigen::Vector3d inward = normal_A.cross(edge).normalized();
    if (inward.dot(p_AQ - corners_A[i]) < -margin) return false;
  }
  return true;
}

SupportPlane Transform(const Pose& X_WA, const SupportPlane& plane_A) {
  SupportPlane plane_W = plane_A;
  plane_W.normal_A = X_WA.linear() * plane_A.normal_A;
  plane_W.offset = plane_A.offset + plane_W.normal_A.dot(X_WA.translation());
  for (int i = 0; i < 4; ++i) plane_W.corners_A[i] = X_WA * plane_A.corners_A[i];
  return plane_W;
}

geometry::PlacedShape SolidBelow(const SupportPlane& plane_W, double margin) {
  const auto& corners_W = plane_W.corners_A;
  const Eigen::Vector3d middle_W =
      0.25 * (corners_W[0] + corners_W[1] + corners_W[2] + corners_W[3]);
  const Eigen::Vector3d along = corners_W[1] - corners_W[0];
  const Eigen::Vector3d across = corners_W[2] - corners_W[1];
  const double top = std::max(middle_W.z(), 1e-3);
  geometry::PlacedShape solid{
      geometry::Box{
          {along.head<2>().norm() + 2.0 * margin, across.head<2>().norm() + 2.0 * margin, top}},
      ToPose({middle_W.x(), middle_W.y(), std::atan2(along.y(), along.x())})};
  solid.X_AS.translation().z() = 0.5 * top;
  return solid;
}

}  // namespace secondlook::world
