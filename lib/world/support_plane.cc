#include "lib/world/support_plane.h"

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

}  // namespace secondlook::world
