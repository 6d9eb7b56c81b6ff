#include "lib/perception/register_scan.h"

#include <algorithm>
#include <utility>

#include "lib/common/error.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;

/// More patches and vertices than these say nothing new; they are taken evenly.
constexpr std::size_t kMostPatches = 1500;
constexpr std::size_t kMostVertices = 20000;
/// How exact a surface is, in its voxels.
constexpr double kExact = 0.1;
/// Cells of the reference, in voxels of the surface.
constexpr double kCell = 5.0 / 3.0;
/// Within the surface the nearest of its points is not farther away than this, in cells.
constexpr double kSlide = 1.5;
/// What holds a direction firmly, in times of what holds it at all.
constexpr double kFirm = 10.0;

std::size_t Stride(std::size_t count, std::size_t most) { return (count + most - 1) / most; }

ReferenceCloud Reference(const world::PartialMesh& surface, double voxel) {
  std::vector<SurfacePoint> points_W;
  const std::size_t count = surface.mesh.vertices.size();
  for (std::size_t i = 0; i < count; i += Stride(count, kMostVertices)) {
    // How exact that is plays no part, for all are alike.
    points_W.push_back({surface.mesh.vertices[i].cast<double>(), surface.normals[i].cast<double>(),
                        kExact * voxel});
  }
  ReferenceCloud reference(kCell * voxel);
  reference.AddView(points_W, Pose::Identity());
  return reference;
}

}  // namespace

RegisterConfig ScanRegisterConfig(double voxel) {
  RegisterConfig config;
  config.first_gate_m = 0.02;
  config.last_gate_m = 0.006;
  config.max_slide_m = kSlide * kCell * voxel;
  config.min_pairs = 60;
  config.common_shift_m = kExact * voxel;
  return config;
}

RegisteredScan RegisterScan(world::RangeScan scan, world::ScanPatches patches,
                            const world::PartialMesh& surface, double voxel,
                            const RegisterConfig& config) {
  if (surface.mesh.vertices.empty()) {
    Throw<InvalidArgument>("registration: the surface is empty; the first scan defines it");
  }
  if (scan.empty()) Throw<InvalidArgument>("registration: the scan has no points");
  if (!(scan.position_sigma > 0.0) || !(scan.rotation_sigma > 0.0)) {
    Throw<InvalidArgument>(
        "registration: the scan's poses have sigmas of {} m and {} rad; both must be positive",
        scan.position_sigma, scan.rotation_sigma);
  }
  const Vector3d p_WC = scan.lines.front().p_WS;
  Pose nominal_X_WC = Pose::Identity();
  nominal_X_WC.translation() = p_WC;
  PoseCovariance covariance = PoseCovariance::Zero();
  covariance.diagonal() << Vector3d::Constant(scan.rotation_sigma * scan.rotation_sigma),
      Vector3d::Constant(scan.position_sigma * scan.position_sigma);

  std::vector<SurfacePoint> points_C;
  const std::size_t count = patches.patches.size();
  for (std::size_t i = 0; i < count; i += Stride(count, kMostPatches)) {
    const world::ScanPatch& patch = patches.patches[i];
    points_C.push_back({patch.p_W - p_WC, patch.normal_W, patch.sigma});
  }
  const ReferenceCloud reference = Reference(surface, voxel);
  RegisteredScan result;
  result.registration = RegisterView(points_C, reference, nominal_X_WC, covariance, config);
  if (!result.registration.accepted) {  // it slid where little held it
    RegisterConfig firm = config;
    firm.min_constraint = std::min(1.0, kFirm * config.min_constraint);
    const ViewRegistration held = RegisterView(points_C, reference, nominal_X_WC, covariance, firm);
    if (held.accepted) result.registration = held;
  }
  if (result.registration.accepted) {
    const Pose move = result.registration.X_WC * nominal_X_WC.inverse();
    for (Vector3d& p_W : scan.points_W) p_W = move * p_W;
    for (world::RangeLine& line : scan.lines) line.p_WS = move * line.p_WS;
    for (world::ScanPatch& patch : patches.patches) {
      patch.p_W = move * patch.p_W;
      patch.normal_W = move.linear() * patch.normal_W;
    }
  }
  result.scan = std::move(scan);
  result.patches = std::move(patches);
  return result;
}

}  // namespace secondlook::perception
