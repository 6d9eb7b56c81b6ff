// Rays of 38 views through the probabilistic voxel space at 10 mm, against OctoMap's castRay() on
// the same voxels: 160 x 120 rays a view, 1.5 m long, or those alone that meet the box of a target,
// with the rays at its mesh. First the gate: ray by ray both must end alike, and every kind of
// difference is counted; the status is 1 when they do not.
#include <array>
#include <cmath>
#include <numbers>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "bench/voxel_scene.h"
#include "lib/geometry/mesh.h"
#include "lib/geometry/ray_caster.h"
#include "lib/world/octomap_exchange.h"
#include "lib/world/ray_cast.h"

namespace secondlook::bench {
namespace {

using Eigen::Vector3d;
using world::Occupancy;

constexpr double kRange_m = 1.5;

/// The candidates of a mission: two rings of base poses around a thing, the camera 1.25 m high.
std::vector<Pose> Views() {
  const Vector3d target(0.1, 0.05, 0.85);
  std::vector<Pose> views;
  for (const double radius : {0.95, 1.35}) {
    for (int i = 0; i < 19; ++i) {
      const double azimuth = 2.0 * std::numbers::pi * i / 19;
      const Vector3d from(radius * std::cos(azimuth), radius * std::sin(azimuth), 0.4);
      views.push_back(testing::LookingAt(target + from, target));
    }
  }
  return views;
}

/// The rays of a view.
world::RayFan Fan(const Pose& X_WC) {
  const geometry::CameraModel camera = kCamera.Scaled(0.25);
  world::RayFan fan{camera, X_WC, {0, 0}, {camera.width, camera.height}, {}};
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      fan.depth.push_back(kRange_m / camera.Ray(u, v).norm());
    }
  }
  return fan;
}

/// Calls `visit(pixel, unit direction_W)` for the rays of the fan.
template <class Visit>
void VisitRays(const world::RayFan& fan, Visit visit) {
  for (int v = 0; v < fan.size.y(); ++v) {
    for (int u = 0; u < fan.size.x(); ++u) {
      visit(v * fan.size.x() + u, (fan.X_WC.linear() * fan.camera.Ray(u, v)).normalized());
    }
  }
}

/// The map after three frames, and after a fourth from another side.
struct Map {
  std::vector<Frame> frames = Frames(Clutter(), 6);
  world::BrickGrid grid{kVoxel_m, Workspace()};
  world::LeapField leaps;

  Map() {
    for (int i = 0; i < 3; ++i) Enter(i);
    leaps.Refresh(grid);
  }
  void Enter(int i) {
    world::EnterDepth(frames[i].depth, kCamera, frames[i].X_WC, Update(), &grid);
  }
};

/// How near the straight line passes to an edge of the voxels that it crosses, at least, in voxels.
double NearestEdge(const Vector3d& from, const Vector3d& direction) {
  double nearest = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) continue;
    const int steps = static_cast<int>(std::abs(direction[axis]) * kRange_m / kVoxel_m);
    for (int i = 0; i <= steps; ++i) {
      const double face = direction[axis] > 0.0 ? std::ceil(from[axis] / kVoxel_m) + i
                                                : std::floor(from[axis] / kVoxel_m) - i;
      const Vector3d at =
          (from + (face * kVoxel_m - from[axis]) / direction[axis] * direction) / kVoxel_m;
      for (int other = 0; other < 3; ++other) {
        if (other != axis) nearest = std::min(nearest, std::abs(at[other] - std::round(at[other])));
      }
    }
  }
  return nearest;
}

/// How the rays of one way to cast compare with OctoMap's.
struct Comparison {
  int rays{};
  int hits{};  ///< In OctoMap.
  int alike{};
  int range_end{};
  int edge{};
  int unexplained{};

  void Add(const Map& map, const Vector3d& from, const Vector3d& direction, bool theirs,
           const Vector3d& p_WTheirs, const world::RayEnd& ours) {
    const bool hit = ours.state == Occupancy::kOccupied;
    ++rays;
    hits += theirs ? 1 : 0;
    if (hit == theirs && (!hit || map.grid.KeyOf(p_WTheirs) == ours.voxel)) {
      ++alike;
      return;
    }
    const Vector3d at = hit ? map.grid.CenterOf(ours.voxel) : p_WTheirs;
    if (hit != theirs && std::abs((at - from).norm() - kRange_m) < 0.87 * kVoxel_m) {
      ++range_end;
    } else if (NearestEdge(from, direction) < 1e-3) {
      ++edge;
    } else {
      ++unexplained;
    }
  }

  bool Passed(const char* name) const {
    fmt::print(stderr,
               "gate: {}: {} rays, {} of them end on a surface in OctoMap; alike {:.4f} %; "
               "differences: {} meet a voxel at the end of the range, which OctoMap measures to "
               "its centre and we to its face; {} pass an edge within 1e-3 of a voxel, where "
               "OctoMap's single precision decides; {} unexplained\n",
               name, rays, hits, 100.0 * alike / rays, range_end, edge, unexplained);
    return alike >= 0.999 * rays && unexplained == 0;
  }
};

bool Agree() {
  const Map map;
  const octomap::OcTree tree = world::ToOctree(map.grid);
  Comparison ray_by_ray;
  Comparison in_beams;
  for (const Pose& X_WC : Views()) {
    const world::RayFan fan = Fan(X_WC);
    const std::vector<world::RayEnd> ends = world::CastFan(map.grid, map.leaps, fan);
    const Vector3d from = X_WC.translation();
    VisitRays(fan, [&](int i, const Vector3d& direction) {
      octomap::point3d end;
      const bool hit = tree.castRay(ToOctomap(from), ToOctomap(direction), end, true, kRange_m);
      const Vector3d p_WHit(end.x(), end.y(), end.z());
      ray_by_ray.Add(map, from, direction, hit, p_WHit,
                     world::CastRay(map.grid, map.leaps, from, from + kRange_m * direction));
      in_beams.Add(map, from, direction, hit, p_WHit, ends[i]);
    });
  }
  return ray_by_ray.Passed("ray by ray") && in_beams.Passed("in beams");
}

enum class Cast { kNothing, kRays, kBeams, kBeamsThroughUnknown };

/// What a fourth frame changed is followed, then all rays are cast.
void OursFollowsAFrame(benchmark::State& state, Cast cast) {
  const Map map;
  const std::vector<Pose> views = Views();
  double bricks = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    Map next = map;
    next.Enter(3);
    state.ResumeTiming();
    bricks += next.leaps.Refresh(next.grid);
    if (cast == Cast::kNothing) continue;
    for (const Pose& X_WC : views) {
      const world::RayFan fan = Fan(X_WC);
      if (cast == Cast::kRays) {
        const Vector3d from = X_WC.translation();
        VisitRays(fan, [&](int /*i*/, const Vector3d& direction) {
          benchmark::DoNotOptimize(
              world::CastRay(next.grid, next.leaps, from, from + kRange_m * direction));
        });
      } else if (cast == Cast::kBeams) {
        benchmark::DoNotOptimize(world::CastFan(next.grid, next.leaps, fan));
      } else {
        benchmark::DoNotOptimize(world::CastFanThroughUnknown(next.grid, next.leaps, fan));
      }
    }
  }
  state.counters["bricks"] = benchmark::Counter(bricks, benchmark::Counter::kAvgIterations);
}
BENCHMARK_CAPTURE(OursFollowsAFrame, NoRays, Cast::kNothing)
    ->Iterations(10)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(OursFollowsAFrame, RayByRay, Cast::kRays)
    ->Iterations(10)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(OursFollowsAFrame, Beams, Cast::kBeams)
    ->Iterations(10)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(OursFollowsAFrame, BeamsThroughUnknown, Cast::kBeamsThroughUnknown)
    ->Iterations(10)
    ->Unit(benchmark::kMillisecond);

void OctoMapCastRay(benchmark::State& state) {
  Map map;
  map.Enter(3);
  const octomap::OcTree tree = world::ToOctree(map.grid);
  const std::vector<Pose> views = Views();
  for (auto _ : state) {
    for (const Pose& X_WC : views) {
      const octomap::point3d from = ToOctomap(X_WC.translation());
      VisitRays(Fan(X_WC), [&](int /*i*/, const Vector3d& direction) {
        octomap::point3d end;
        benchmark::DoNotOptimize(tree.castRay(from, ToOctomap(direction), end, true, kRange_m));
      });
    }
  }
}
BENCHMARK(OctoMapCastRay)->Iterations(1)->Unit(benchmark::kMillisecond);

/// What the views are for: a thing and the box around it.
struct Target {
  Pose X_WM{Pose::Identity()};
  geometry::RayCaster caster{geometry::MakeCylinder(0.05, 0.2, 64, {1, 1, 1})};
  Eigen::AlignedBox3d box_W{Vector3d(0.02, -0.03, 0.73), Vector3d(0.18, 0.13, 0.98)};

  Target() { X_WM.translation() << 0.1, 0.05, 0.75; }

  /// Casts the rays of the directions at the mesh.
  std::vector<geometry::RayHit> Cast(const Pose& X_WC,
                                     const std::vector<Vector3d>& directions_W) const {
    const Pose X_MW = X_WM.inverse();
    std::vector<geometry::Ray> rays_M;
    for (const Vector3d& direction_W : directions_W) {
      rays_M.push_back(
          {(X_MW * X_WC.translation()).cast<float>(), (X_MW.linear() * direction_W).cast<float>()});
    }
    return caster.Cast(rays_M);
  }
};

/// The rays of a view that meet the target's box, up to where they do, and no pixels beyond.
world::RayFan BoxFan(const Pose& X_WC, const Target& target) {
  const world::RayFan whole = Fan(X_WC);
  std::vector<double> depth(whole.depth.size(), 0.0);
  Eigen::AlignedBox2i pixels;
  VisitRays(whole, [&](int i, const Vector3d& direction) {
    const auto [enter, leave] =
        world::ShareInside(target.box_W, X_WC.translation(), X_WC.translation() + 3.0 * direction);
    if (!(enter < leave)) return;
    depth[i] = 3.0 * enter * whole.depth[i] / kRange_m;  // a metre along is this deep
    pixels.extend(Eigen::Vector2i(i % whole.size.x(), i / whole.size.x()));
  });
  world::RayFan fan{whole.camera, X_WC, pixels.min(), pixels.sizes().array() + 1, {}};
  for (int v = pixels.min().y(); v <= pixels.max().y(); ++v) {
    for (int u = pixels.min().x(); u <= pixels.max().x(); ++u) {
      fan.depth.push_back(depth[v * whole.size.x() + u]);
    }
  }
  return fan;
}

std::vector<world::RayFan> BoxFans(const Target& target) {
  std::vector<world::RayFan> fans;
  for (const Pose& X_WC : Views()) fans.push_back(BoxFan(X_WC, target));
  return fans;
}

/// Of a pixel of the fan, 1 along the optical axis.
Vector3d DirectionOf(const world::RayFan& fan, int i) {
  return fan.X_WC.linear() *
         fan.camera.Ray(fan.first.x() + i % fan.size.x(), fan.first.y() + i / fan.size.x());
}

/// As a mission does: through free and unknown space, then at the mesh.
void OursChoosesForATarget(benchmark::State& state) {
  const Map map;
  const Target target;
  const std::vector<world::RayFan> fans = BoxFans(target);
  double bricks = 0.0;
  double rays = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    Map next = map;
    next.Enter(3);
    state.ResumeTiming();
    bricks += next.leaps.Refresh(next.grid);
    for (const world::RayFan& fan : fans) {
      const std::vector<world::RayEnd> ends =
          world::CastFanThroughUnknown(next.grid, next.leaps, fan);
      std::vector<Vector3d> arriving_W;
      for (int i = 0; i < static_cast<int>(ends.size()); ++i) {
        if (!(fan.depth[i] > 0.0)) continue;
        rays += 1.0;
        if (ends[i].state != Occupancy::kOccupied) arriving_W.push_back(DirectionOf(fan, i));
      }
      benchmark::DoNotOptimize(target.Cast(fan.X_WC, arriving_W));
    }
  }
  state.counters["bricks"] = benchmark::Counter(bricks, benchmark::Counter::kAvgIterations);
  state.counters["rays"] = benchmark::Counter(rays, benchmark::Counter::kAvgIterations);
}
BENCHMARK(OursChoosesForATarget)->Iterations(20)->Unit(benchmark::kMillisecond);

void OctoMapChoosesForATarget(benchmark::State& state) {
  Map map;
  map.Enter(3);
  const octomap::OcTree tree = world::ToOctree(map.grid);
  const Target target;
  const std::vector<world::RayFan> fans = BoxFans(target);
  for (auto _ : state) {
    for (const world::RayFan& fan : fans) {
      const octomap::point3d from = ToOctomap(fan.X_WC.translation());
      std::vector<Vector3d> arriving_W;
      for (int i = 0; i < static_cast<int>(fan.depth.size()); ++i) {
        if (!(fan.depth[i] > 0.0)) continue;
        const Vector3d direction_W = DirectionOf(fan, i);
        octomap::point3d end;
        if (!tree.castRay(from, ToOctomap(direction_W), end, true,
                          fan.depth[i] * direction_W.norm())) {
          arriving_W.push_back(direction_W);
        }
      }
      benchmark::DoNotOptimize(target.Cast(fan.X_WC, arriving_W));
    }
  }
}
BENCHMARK(OctoMapChoosesForATarget)->Iterations(3)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace secondlook::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (!secondlook::bench::Agree()) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
