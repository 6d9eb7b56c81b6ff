#include "lib/perception/surface.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "lib/geometry/point_image.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;

Vector3d FitNormal(const PointVoxels& voxels, int i, const std::vector<int>& window) {
  if (window.size() < 4) return Vector3d::Zero();
  Vector3d mean = voxels.mean(i);
  for (const int j : window) mean += voxels.mean(j);
  mean /= static_cast<double>(window.size() + 1);
  Eigen::Matrix3d moments = (voxels.mean(i) - mean) * (voxels.mean(i) - mean).transpose();
  for (const int j : window) {
    const Vector3d d = voxels.mean(j) - mean;
    moments += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moments);
  const Vector3d normal = eigen.eigenvectors().col(0);
  return normal.dot(voxels.mean(i)) > 0.0 ? Vector3d(-normal) : normal;
}

/// The principal curvatures at voxel `i`: how the normal turns along the surface, by least squares.
void FitCurvature(const PointVoxels& voxels, int i, const std::vector<int>& window,
                  std::vector<SurfacePatch>* patches) {
  SurfacePatch& patch = (*patches)[i];
  if (patch.normal_C.isZero()) return;
  const Vector3d u = patch.normal_C.unitOrthogonal();
  const Vector3d v = patch.normal_C.cross(u);
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const int j : window) {
    const Vector3d& normal = (*patches)[j].normal_C;
    if (normal.isZero()) continue;
    const Vector3d d = voxels.mean(j) - voxels.mean(i);
    const Vector3d turn = normal - patch.normal_C;
    const Vector3d along_u(d.dot(u), d.dot(v), 0.0);
    const Vector3d along_v(0.0, d.dot(u), d.dot(v));
    moments += along_u * along_u.transpose() + along_v * along_v.transpose();
    right += along_u * turn.dot(u) + along_v * turn.dot(v);
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> solver(moments);
  if (solver.rank() < 3) return;
  const Vector3d shape = solver.solve(right);
  const double middle = (shape.x() + shape.z()) / 2.0;
  const double half = std::hypot((shape.x() - shape.z()) / 2.0, shape.y());
  patch.min_curvature = middle - half;
  patch.max_curvature = middle + half;
}

}  // namespace

double SurfaceWindow(const std::vector<Vector3d>& points_C, double least) {
  double depth = 0.0;
  for (const Vector3d& p : points_C) depth += p.z() / static_cast<double>(points_C.size());
  return std::max(least, 6.0 * geometry::DepthSigma(depth));
}

std::vector<SurfacePatch> FitSurface(const PointVoxels& voxels_C,
                                     const std::vector<std::vector<int>>& windows) {
  std::vector<SurfacePatch> patches(voxels_C.size());
  for (int i = 0; i < voxels_C.size(); ++i) {
    patches[i].normal_C = FitNormal(voxels_C, i, windows[i]);
  }
  for (int i = 0; i < voxels_C.size(); ++i) FitCurvature(voxels_C, i, windows[i], &patches);
  return patches;
}

}  // namespace secondlook::perception
