#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/hal/joint_trajectory.h"
#include "lib/kinematics/chain.h"
#include "lib/world/voxel_space.h"

namespace secondlook::planning {

inline kinematics::Chain SimulatedArm() {
  return {kinematics::LoadUrdf("sim/robots/arm.urdf"), "flange"};
}

/// The joints of `chain`, all with one limit of acceleration [rad/s^2].
inline std::vector<hal::JointInfo> JointsOf(const kinematics::Chain& chain, double acceleration) {
  std::vector<hal::JointInfo> joints;
  for (int i = 0; i < chain.size(); ++i) {
    const kinematics::Joint& joint = chain.joint(i);
    joints.push_back({joint.name, joint.lower, joint.upper, joint.speed, acceleration});
  }
  return joints;
}

inline Eigen::VectorXd Degrees(std::initializer_list<double> degrees) {
  Eigen::VectorXd q(static_cast<Eigen::Index>(degrees.size()));
  int i = 0;
  for (const double angle : degrees) q[i++] = angle * M_PI / 180.0;
  return q;
}

/// Free of everything for 1.8 m around the robot and as high.
inline world::VoxelSpace FreeSpace() {
  world::VoxelSpace space;
  space.ClearBox({Eigen::Vector3d(-1.8, -1.8, 0.0), Eigen::Vector3d(1.8, 1.8, 2.4)});
  return space;
}

/// Fills a box with occupied voxels and returns their centres.
inline std::vector<Eigen::Vector3d> Occupy(const Eigen::AlignedBox3d& box_W,
                                           world::VoxelSpace* space) {
  std::vector<Eigen::Vector3d> centers;
  const world::BrickGrid& grid = space->surroundings();
  const world::VoxelKey low = grid.KeyOf(box_W.min());
  const world::VoxelKey high = grid.KeyOf(box_W.max());
  for (int x = low.x(); x <= high.x(); ++x) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int z = low.z(); z <= high.z(); ++z) centers.push_back(grid.CenterOf({x, y, z}));
    }
  }
  space->MarkOccupied(centers);
  return centers;
}

}  // namespace secondlook::planning
