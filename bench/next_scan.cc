// What a next scan costs: entropy along 160 x 120 rays, 1.5 m long, of 100 candidate views in one
// thread, and registering and integrating a scan of 200,000 points in voxels of 1 mm. First the
// gate: the sums of entropy of five views against OctoMap's octree, walked ray by ray and voxel by
// voxel; the status is 1 when they differ by more than 0.2 %.
#include <cmath>
#include <numbers>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <octomap/octomap.h>

#include "bench/voxel_scene.h"
#include "lib/perception/register_scan.h"
#include "lib/planning/scan_gain.h"
#include "lib/world/octomap_exchange.h"
#include "tests/support/scan_of.h"

namespace secondlook::bench {
namespace {

using Eigen::Vector3d;

constexpr double kRange_m = 1.5;
constexpr int kViews = 100;

/// A map of the table from three sides: the rest is unknown.
world::BrickGrid Map(double voxel) {
  world::BrickGrid grid(voxel, Workspace());
  for (const Frame& frame : Frames(Clutter(), 3)) {
    world::EnterDepth(frame.depth, kCamera, frame.X_WC, Update(), &grid);
  }
  return grid;
}

/// Candidates all around the table's middle, 0.9 m away, evenly over the upper half of the sphere.
std::vector<Pose> Views() {
  const Vector3d target(0.1, 0.05, 0.85);
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  std::vector<Pose> views;
  for (int i = 0; i < kViews; ++i) {
    const double up = (i + 0.5) / kViews;
    const double level = std::sqrt(1.0 - up * up);
    views.push_back(testing::LookingAt(
        target + 0.9 * Vector3d(level * std::cos(golden * i), level * std::sin(golden * i), up),
        target));
  }
  return views;
}

/// The sum of entropy by the octree, in what of a ray lies in the workspace's grid.
double OctreeEntropy(const octomap::OcTree& tree, const Eigen::AlignedBox3d& box_W,
                     const Pose& X_WC) {
  const geometry::CameraModel camera = kCamera.Scaled(0.25);
  octomap::KeyRay keys;
  double sum = 0.0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Vector3d end =
          X_WC.translation() + kRange_m * (X_WC.linear() * camera.Ray(u, v)).normalized();
      tree.computeRayKeys(ToOctomap(X_WC.translation()), ToOctomap(end), keys);
      keys.addKey(tree.coordToKey(ToOctomap(end)));  // which it leaves out
      for (const octomap::OcTreeKey& key : keys) {
        const octomap::point3d at = tree.keyToCoord(key);
        if (!box_W.contains(Vector3d(at.x(), at.y(), at.z()))) continue;
        const octomap::OcTreeNode* node = tree.search(key);
        const double p = node == nullptr ? 0.5 : node->getOccupancy();
        sum -= p * std::log2(p) + (1.0 - p) * std::log2(1.0 - p);
        if (node != nullptr && tree.isNodeOccupied(node)) break;
      }
    }
  }
  return sum;
}

bool EntropyAgrees(double voxel) {
  const world::BrickGrid grid = Map(voxel);
  const octomap::OcTree tree = world::ToOctree(grid);
  const planning::ScanGainField field(grid, {}, {}, {}, {});
  const std::vector<Pose> views = Views();
  double ours = 0.0;
  double octree = 0.0;
  for (int i = 0; i < kViews; i += kViews / 5) {
    ours += field.Measure(kCamera.Scaled(0.25), views[i]).entropy;
    octree += OctreeEntropy(tree, grid.box_W(), views[i]);
  }
  const double off = ours / octree - 1.0;
  fmt::print("entropy at {} mm: {:.0f} bit, by the octree {:.0f}: {:+.3f} %\n", 1000 * voxel, ours,
             octree, 100.0 * off);
  return std::abs(off) <= 0.002;
}

void EntropyOfCandidates(benchmark::State& state) {
  const world::BrickGrid grid = Map(1e-3 * static_cast<double>(state.range(0)));
  const std::vector<Pose> views = Views();
  for (auto _ : state) {
    const planning::ScanGainField field(grid, {}, {}, {}, {});
    for (const Pose& X_WC : views) {
      benchmark::DoNotOptimize(field.Measure(kCamera.Scaled(0.25), X_WC));
    }
  }
}
BENCHMARK(EntropyOfCandidates)->Arg(20)->Arg(10)->Unit(benchmark::kMillisecond)->MinTime(2.0);

/// A scan of a can on a plate with about 200,000 points.
world::RangeScan Scan(const Vector3d& from) {
  geometry::Mesh mesh = geometry::MakeCylinder(0.05, 0.15, 100, Eigen::Vector3f::Constant(0.5F));
  const geometry::Mesh plate = geometry::MakeBox({0.4, 0.4, 0.002}, {0.5F, 0.5F, 0.5F});
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), plate.vertices.begin(), plate.vertices.end());
  for (const Eigen::Vector3i& t : plate.triangles) {
    mesh.triangles.emplace_back(t + Eigen::Vector3i::Constant(first));
  }
  Rng rng(7);
  world::RangeScan scan = tests::ScanOf(mesh, from, {0, 0, 0.06}, 450, 0.00045, 0.0001, &rng);
  scan.position_sigma = 0.002;
  scan.rotation_sigma = 0.005;
  return scan;
}

void RegisterAndIntegrate(benchmark::State& state) {
  const world::SurfaceConfig config{.voxel_m = 0.001};
  const Eigen::AlignedBox3d box(Vector3d(-0.2, -0.2, -0.01), Vector3d(0.2, 0.2, 0.3));
  const world::RangeScan second = Scan({0.3, -0.2, 0.25});
  for (auto _ : state) {
    state.PauseTiming();
    world::SurfaceVolume volume(config, box);
    volume.Integrate(Scan({0.35, 0.0, 0.25}));
    const world::PartialMesh surface = volume.Extract();
    state.ResumeTiming();
    const perception::RegisteredScan registered =
        perception::RegisterScan(second, world::CutIntoPatches(second, volume.patch()), surface,
                                 config.voxel_m, perception::ScanRegisterConfig(config.voxel_m));
    benchmark::DoNotOptimize(volume.Integrate(registered.scan, registered.patches));
  }
  state.counters["points"] = static_cast<double>(second.points_W.size());
}
BENCHMARK(RegisterAndIntegrate)->Unit(benchmark::kMillisecond)->Iterations(5);

void ExtractSurface(benchmark::State& state) {
  world::SurfaceVolume volume({.voxel_m = 0.001},
                              {Vector3d(-0.2, -0.2, -0.01), Vector3d(0.2, 0.2, 0.3)});
  volume.Integrate(Scan({0.35, 0.0, 0.25}));
  std::size_t triangles = 0;
  for (auto _ : state) triangles = volume.Extract().mesh.triangles.size();
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(ExtractSurface)->Unit(benchmark::kMillisecond)->Iterations(5);

}  // namespace
}  // namespace secondlook::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const bool agree =
      secondlook::bench::EntropyAgrees(0.02) && secondlook::bench::EntropyAgrees(0.01);
  benchmark::RunSpecifiedBenchmarks();
  return agree ? 0 : 1;
}
