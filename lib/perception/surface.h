#pragma once

#include <vector>

#include <Eigen/Core>

#include "lib/perception/point_voxels.h"

namespace secondlook::perception {

/// The surface at one voxel of a cluster, as its neighbours within a window show it.
struct SurfacePatch {
  Eigen::Vector3d normal_C{Eigen::Vector3d::Zero()};  ///< Towards the camera; zero: too few points.
  /// The principal curvatures [1/m], the more concave first; a ball's outside is positive.
  double min_curvature{};
  double max_curvature{};

  double mean_curvature() const { return (min_curvature + max_curvature) / 2.0; }
};

/// How wide around a point its surface is looked at [m]: `least`, or 6 sigma of the depth at the
/// mean of `points_C`, so that noise does not bend it.
double SurfaceWindow(const std::vector<Eigen::Vector3d>& points_C, double least);

/// The surface at each voxel; `windows` are the neighbours to look at.
std::vector<SurfacePatch> FitSurface(const PointVoxels& voxels_C,
                                     const std::vector<std::vector<int>>& windows);

}  // namespace secondlook::perception
