#include "lib/planning/tile_view.h"

#include "lib/common/error.h"

namespace secondlook::planning {

Pose TileView(Tile tile, const Eigen::Vector3d& p_CO, double distance) {
  if (!p_CO.allFinite() || !(p_CO.z() > 0.0)) {
    Throw<InvalidArgument>("an object at ({:.3f}, {:.3f}, {:.3f}) m is not before the camera",
                           p_CO.x(), p_CO.y(), p_CO.z());
  }
  if (!(distance > 0.0)) {
    Throw<InvalidArgument>("a view from {} m; the distance must be positive", distance);
  }
  Eigen::Vector3d from_C = Eigen::Vector3d::Zero();
  from_C.head<2>() = TileDirection(tile);
  const Eigen::Vector3d z_C = -from_C;
  Eigen::Vector3d down_C = Eigen::Vector3d::UnitY();
  if (from_C.x() == 0.0) down_C = {0.0, 0.0, from_C.y()};
  const Eigen::Vector3d x_C = down_C.cross(z_C).normalized();
  Pose X_CV = Pose::Identity();
  X_CV.linear() << x_C, z_C.cross(x_C), z_C;
  X_CV.translation() = p_CO + distance * from_C;
  return X_CV;
}

}  // namespace secondlook::planning
