// The probabilistic voxel space takes one 640 x 480 frame at 10 mm, against OctoMap cropped to the
// same box. First the gate: after three frames, the two maps must agree; the status is 1 when they
// do not.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "bench/voxel_scene.h"
#include "lib/world/leap_field.h"
#include "lib/world/ray_cast.h"

namespace secondlook::bench {
namespace {

using world::BrickGrid;
using world::Occupancy;

constexpr int kFrames = 6;

const std::vector<Frame>& TheFrames() {
  static const std::vector<Frame> frames = Frames(Clutter(), kFrames);
  return frames;
}

Occupancy StateIn(const octomap::OcTree& tree, const Eigen::Vector3d& p) {
  const octomap::OcTreeNode* node = tree.search(ToOctomap(p));
  if (node == nullptr) return Occupancy::kUnknown;
  return tree.isNodeOccupied(node) ? Occupancy::kOccupied : Occupancy::kFree;
}

/// Calls `visit` with the centre of every voxel of the grid.
template <class Visit>
void VisitVoxels(const BrickGrid& grid, Visit visit) {
  const Eigen::Vector3i size = grid.brick_count() * world::Brick::kEdge;
  for (int z = 0; z < size.z(); ++z) {
    for (int y = 0; y < size.y(); ++y) {
      for (int x = 0; x < size.x(); ++x) {
        visit(grid.CenterOf(grid.first_key() + world::VoxelKey(x, y, z)));
      }
    }
  }
}

bool NearOccupied(const BrickGrid& grid, const Eigen::Vector3d& p) {
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3d step(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (grid.At(p + grid.voxel() * step) == Occupancy::kOccupied) return true;
  }
  return false;
}

/// Three frames entered in OctoMap without a crop, voxel by voxel against ours.
bool Agree() {
  BrickGrid grid(kVoxel_m, Workspace());
  octomap::OcTree tree(kVoxel_m);
  for (int i = 0; i < 3; ++i) {
    const Frame& frame = TheFrames()[i];
    world::EnterDepth(frame.depth, kCamera, frame.X_WC, Update(), &grid);
    tree.insertPointCloud(Cloud(frame), ToOctomap(frame.X_WC.translation()), -1.0, true, true);
  }
  int both = 0;
  int ours = 0;
  int theirs = 0;
  int same = 0;
  int all = 0;
  int free_on_surface = 0;
  VisitVoxels(grid, [&](const Eigen::Vector3d& p) {
    const Occupancy a = grid.At(p);
    const Occupancy b = StateIn(tree, p);
    ++all;
    same += a == b ? 1 : 0;
    ours += a == Occupancy::kOccupied ? 1 : 0;
    theirs += b == Occupancy::kOccupied ? 1 : 0;
    both += a == Occupancy::kOccupied && b == Occupancy::kOccupied ? 1 : 0;
    if (a == Occupancy::kFree && b == Occupancy::kOccupied && !NearOccupied(grid, p)) {
      ++free_on_surface;
    }
  });
  const double recall = 100.0 * both / theirs;
  const double precision = 100.0 * both / ours;
  fmt::print(
      stderr,
      "gate: {} voxels, {:.3f} % in the same state; {} occupied in OctoMap: recall {:.3f} %, "
      "precision {:.3f} %; free where OctoMap has a surface away from ours: {}\n",
      all, 100.0 * same / all, theirs, recall, precision, free_on_surface);
  return recall >= 98.0 && precision >= 98.0 && free_on_surface == 0;
}

/// Both begin with a map of two frames and enter the others in turn.
void OursEntersAFrame(benchmark::State& state) {
  BrickGrid grid(kVoxel_m, Workspace());
  for (int i = 0; i < 2; ++i) {
    world::EnterDepth(TheFrames()[i].depth, kCamera, TheFrames()[i].X_WC, Update(), &grid);
  }
  int i = 2;
  double bricks = 0.0;
  for (auto _ : state) {
    const Frame& frame = TheFrames()[i++ % kFrames];
    bricks += world::EnterDepth(frame.depth, kCamera, frame.X_WC, Update(), &grid);
  }
  state.counters["bricks"] = benchmark::Counter(bricks, benchmark::Counter::kAvgIterations);
}
BENCHMARK(OursEntersAFrame)->Iterations(24)->Unit(benchmark::kMillisecond);

/// What OctoMap is asked to do.
enum class Crop {
  kBox,          ///< insertPointCloud() with its bounding box: rays that end out of it are dropped.
  kDiscretised,  ///< … with end points discretised first.
  kLeavingRaysToo  ///< … and rays that leave the box free their way in it, as they do with us.
};

/// Enters the frame's rays that leave the box as free up to there, and those that end in it.
void EnterWithLeavingRays(const Frame& frame, const octomap::Pointcloud& cloud,
                          octomap::OcTree* tree) {
  const octomap::point3d origin = ToOctomap(frame.X_WC.translation());
  octomap::KeySet free;
  octomap::KeySet occupied;
  octomap::KeySet exits;
  octomap::KeyRay keys;
  tree->computeDiscreteUpdate(cloud, origin, free, occupied, -1.0);
  for (const octomap::point3d& point : cloud) {
    if (tree->inBBX(point)) continue;
    const Eigen::Vector3d p_W(point.x(), point.y(), point.z());
    const auto [enter, leave] = world::ShareInside(Workspace(), frame.X_WC.translation(), p_W);
    if (!(enter < leave)) continue;
    const octomap::point3d way = point - origin;
    const octomap::OcTreeKey exit = tree->coordToKey(origin + way * static_cast<float>(leave));
    if (!exits.insert(exit).second) continue;
    tree->computeRayKeys(origin + way * static_cast<float>(enter), tree->keyToCoord(exit), keys);
    free.insert(keys.begin(), keys.end());
  }
  for (const octomap::OcTreeKey& key : free) {
    if (occupied.count(key) == 0) tree->updateNode(key, false, true);
  }
  for (const octomap::OcTreeKey& key : occupied) tree->updateNode(key, true, true);
}

void OctoMapEntersAFrame(benchmark::State& state, Crop crop) {
  octomap::OcTree tree = CroppedOctree();
  std::vector<octomap::Pointcloud> clouds;
  for (const Frame& frame : TheFrames()) clouds.push_back(Cloud(frame));
  const auto enter = [&](int i) {
    const Frame& frame = TheFrames()[i];
    if (crop == Crop::kLeavingRaysToo) {
      EnterWithLeavingRays(frame, clouds[i], &tree);
    } else {
      tree.insertPointCloud(clouds[i], ToOctomap(frame.X_WC.translation()), -1.0, true,
                            crop == Crop::kDiscretised);
    }
    tree.updateInnerOccupancy();
  };
  enter(0);
  enter(1);
  int i = 2;
  for (auto _ : state) enter(i++ % kFrames);
}
BENCHMARK_CAPTURE(OctoMapEntersAFrame, Box, Crop::kBox)
    ->Iterations(6)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(OctoMapEntersAFrame, Discretised, Crop::kDiscretised)
    ->Iterations(6)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(OctoMapEntersAFrame, LeavingRaysToo, Crop::kLeavingRaysToo)
    ->Iterations(6)
    ->Unit(benchmark::kMillisecond);

/// All of 1.5 x 1.0 x 0.8 m known at 5 mm, with what ray casting needs.
void OursAt5mm(benchmark::State& state) {
  BrickGrid grid(0.005, Workspace());
  world::LeapField leaps;
  int i = 0;
  for (auto _ : state) {
    const Frame& frame = TheFrames()[i++ % kFrames];
    world::EnterDepth(frame.depth, kCamera, frame.X_WC, Update(), &grid);
    leaps.Refresh(grid);
  }
  grid.Fill(Workspace(), -1.0F);
  leaps.Refresh(grid);
  state.counters["MB"] = static_cast<double>(grid.memory() + leaps.memory()) / 1e6;
}
BENCHMARK(OursAt5mm)->Iterations(kFrames)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace secondlook::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (!secondlook::bench::Agree()) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
