#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/free_camera.h"
#include "apps/experiments/pedestal.h"
#include "apps/experiments/random_scene.h"
#include "apps/experiments/reachable_surface.h"
#include "lib/common/stopwatch.h"
#include "lib/perception/coverage.h"
#include "lib/perception/register_scan.h"
#include "lib/perception/striped_scan.h"
#include "lib/planning/motion/plan_sweep.h"
#include "lib/world/surface_volume.h"
#include "sim/line_scanner.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kAround = 0.04;  // [m] of the table that a scan keeps around the object
constexpr double kLane = 0.1;     // [m] from a sweep to the one beside it; the fan is 0.11 wide
constexpr double kLongestSweep = 0.3;  // [m]
constexpr double kSpeed = 0.04;        // [m/s] of a sweep
constexpr double kNearest = 0.52;      // [m] from the depth camera to the object
constexpr double kFoot = 0.001;        // [m] above the table the object begins
constexpr int kTruePoints = 30'000;
constexpr double kSpacing = 0.0005;  // [m] of points that stand for a measured surface

/// The ring: on the half sphere about the object, from where a sensor looks at it.
std::vector<Vector3d> Ring() {
  std::vector<Vector3d> directions;
  const std::pair<double, int> circles[] = {{25.0, 12}, {50.0, 8}, {75.0, 4}};
  for (const auto& [elevation_deg, count] : circles) {
    const double up = elevation_deg * kDegree;
    for (int i = 0; i < count; ++i) {
      const double around = 2.0 * std::numbers::pi * (i + 0.5) / count;
      directions.emplace_back(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                              std::sin(up));
    }
  }
  return directions;
}

/// An object on its pedestal, and what is kept of a scan of it.
struct Subject {
  const sim::World& world;
  Eigen::AlignedBox3d box_W;   // of the object
  Eigen::AlignedBox3d kept_W;  // with a piece of the table around it
};

Subject SubjectOf(const sim::World& world) {
  Subject subject{world, {}, {}};
  const sim::PlacedObject& object = world.objects().at(0);
  for (const Eigen::Vector3f& p_M : object.mesh.vertices) {
    subject.box_W.extend(object.X_WM * p_M.cast<double>());
  }
  subject.kept_W = subject.box_W;
  subject.kept_W.extend(subject.box_W.min() - Vector3d::Constant(kAround));
  subject.kept_W.extend(subject.box_W.max() + Vector3d::Constant(kAround));
  subject.kept_W.min().z() = world.scene().table.height - 0.01;
  return subject;
}

/// `scan` without the points that lie outside of `box_W`.
world::RangeScan Within(const world::RangeScan& scan, const Eigen::AlignedBox3d& box_W) {
  world::RangeScan kept;
  kept.position_sigma = scan.position_sigma;
  kept.rotation_sigma = scan.rotation_sigma;
  int i = 0;
  for (const world::RangeLine& line : scan.lines) {
    for (; i < line.end; ++i) {
      if (!box_W.contains(scan.points_W[i])) continue;
      kept.points_W.push_back(scan.points_W[i]);
      kept.sigmas.push_back(scan.sigmas[i]);
    }
    kept.lines.push_back({line.p_WS, static_cast<int>(kept.points_W.size())});
  }
  return kept;
}

/// How well a scan's pose is known against that of the first, which errs as well: that of the arm,
/// with the mounting of what it carries.
perception::LaserPrecision PrecisionOf(const sim::NoiseConfig& noise) {
  return {
      std::numbers::sqrt2 * std::hypot(noise.arm_sigma, noise.hand_eye_sigma),
      std::numbers::sqrt2 * std::hypot(noise.arm_sigma_deg, noise.hand_eye_sigma_deg) * kDegree};
}

/// The laser, swept over the object along each direction, as often side by side as it takes.
class StriperScans {
 public:
  StriperScans(const Subject& subject, std::uint64_t seed)
      : subject_(subject),
        noise_(subject.world.noise()),
        scanner_(subject.world.fixtures(), noise_, seed),
        seed_(seed) {}

  std::vector<world::RangeScan> From(const Vector3d& direction_W, Rng* rng) const {
    const Vector3d size = subject_.box_W.sizes();
    const int lanes = static_cast<int>(std::ceil(size.head<2>().norm() / kLane));
    const Vector3d side_W = Vector3d::UnitZ().cross(direction_W).normalized();
    std::vector<world::RangeScan> scans;
    for (int lane = 0; lane < lanes; ++lane) {
      const Vector3d target_W =
          subject_.box_W.center() + (lane - 0.5 * (lanes - 1)) * kLane * side_W;
      scans.push_back(Sweep(
          planning::SweepOver(target_W, -direction_W, direction_W.cross(side_W),
                              std::min(kLongestSweep, size.norm() + kAround), scanner_.info()),
          rng));
    }
    return scans;
  }

 private:
  world::RangeScan Sweep(const planning::SweepGoal& goal, Rng* rng) const {
    const Duration seconds = Seconds(goal.length_m / kSpeed);
    sim::StriperDrive drive(Pose::Identity(), 10'000, noise_, seed_);
    const Pose X_EEtrue = SmallMotion(noise_.arm_sigma, noise_.arm_sigma_deg, rng);
    PoseHistory X_WL("X_WL", Seconds(100.0));
    const Time begin(Seconds(1.0));
    drive.Light(begin + seconds);
    for (Time now = begin; now <= begin + seconds + Seconds(0.1); now += sim::World::kStep) {
      const double along = kSpeed * ToSeconds(now - begin) - 0.5 * goal.length_m;
      const Pose X = goal.X_WL * Eigen::Translation3d(0.0, along, 0.0);
      X_WL.Add(now, X);
      drive.Step(now, X * X_EEtrue);
    }
    std::vector<hal::ScanLine> lines;
    for (sim::Shot shot : drive.Take()) {
      shot.sequence += rng->Bits();  // noise of its own in each sweep
      lines.push_back(scanner_.Measure(shot));
      lines.back().time = std::max(lines.back().time, begin);
    }
    return perception::StripedScan(lines, scanner_.info(), X_WL, PrecisionOf(noise_));
  }

  const Subject& subject_;
  const sim::NoiseConfig& noise_;
  sim::LineScanner scanner_;
  std::uint64_t seed_;
};

/// The depth camera in the hand, a frame from each direction.
class DepthScans {
 public:
  DepthScans(const Subject& subject, FreeCamera* camera, Rng* rng)
      : subject_(subject), noise_(subject.world.noise()), camera_(*camera) {
    X_CCtrue_ = SmallMotion(noise_.hand_eye_sigma, noise_.hand_eye_sigma_deg, rng);
  }

  std::vector<world::RangeScan> From(const Vector3d& direction_W, Rng* rng) const {
    const double distance = kNearest + 0.5 * subject_.box_W.sizes().norm();
    const Vector3d target_W = subject_.box_W.center();
    const Pose X_WC = LookAt(target_W + distance * direction_W, target_W);
    const Photo photo = camera_.Take(
        X_WC * SmallMotion(noise_.arm_sigma, noise_.arm_sigma_deg, rng) * X_CCtrue_, rng);
    const perception::LaserPrecision precision = PrecisionOf(noise_);
    world::RangeScan scan;
    scan.position_sigma = precision.position_sigma;
    scan.rotation_sigma = precision.rotation_sigma;
    const cv::Mat& depth = photo.frame.depth;
    for (int v = 0; v < depth.rows; ++v) {
      for (int u = 0; u < depth.cols; ++u) {
        const double z = depth.at<float>(v, u);
        if (!(z > 0.0)) continue;
        scan.points_W.emplace_back(X_WC * (z * camera_.info().model.Ray(u, v)));
        scan.sigmas.push_back(static_cast<float>(sim::AxialSigma(z, 0.0)));
      }
    }
    scan.lines = {{X_WC.translation(), static_cast<int>(scan.points_W.size())}};
    return {scan};
  }

 private:
  const Subject& subject_;
  const sim::NoiseConfig& noise_;
  FreeCamera& camera_;
  Pose X_CCtrue_{Pose::Identity()};
};

/// The table beside the object, as it was measured: the least squares plane of what lies level near
/// its height.
world::SupportPlane TableIn(const world::PartialMesh& surface, const Subject& subject) {
  const double height = subject.world.scene().table.height;
  Eigen::Matrix3d normal_equations = 1e-9 * Eigen::Matrix3d::Identity();
  Vector3d right = Vector3d::Zero();
  for (std::size_t i = 0; i < surface.mesh.vertices.size(); ++i) {
    const Vector3d p = surface.mesh.vertices[i].cast<double>();
    if (std::abs(p.z() - height) > 0.008 || surface.normals[i].z() < 0.95F) continue;
    if (p.x() > subject.box_W.min().x() - 0.01 && p.x() < subject.box_W.max().x() + 0.01 &&
        p.y() > subject.box_W.min().y() - 0.01 && p.y() < subject.box_W.max().y() + 0.01) {
      continue;
    }
    const Vector3d row(p.x(), p.y(), 1.0);
    normal_equations += row * row.transpose();
    right += (p.z() - height) * row;
  }
  const Vector3d slope = normal_equations.ldlt().solve(right);
  world::SupportPlane plane;
  plane.normal_A = Vector3d(-slope.x(), -slope.y(), 1.0).normalized();
  plane.offset = plane.normal_A.dot(Vector3d(0.0, 0.0, height + slope.z()));
  return plane;
}

/// All scans of one sensor, fused, and compared with the truth.
template <class Scans>
Json Measure(const Scans& scans, double voxel, const Subject& subject,
             const std::vector<SurfacePoint>& truth, Rng* rng) {
  world::SurfaceConfig config;
  config.voxel_m = voxel;
  world::SurfaceVolume volume(config, subject.kept_W);
  const perception::RegisterConfig registering = perception::ScanRegisterConfig(voxel);
  int taken = 0;
  int refused = 0;
  std::size_t points = 0;
  double seconds = 0.0;
  for (const Vector3d& direction_W : Ring()) {
    for (const world::RangeScan& whole : scans.From(direction_W, rng)) {
      world::RangeScan scan = Within(whole, subject.kept_W);
      if (scan.empty()) continue;
      ++taken;
      points += scan.points_W.size();
      const world::PartialMesh surface = volume.Extract();
      const Stopwatch watch;
      world::ScanPatches patches = world::CutIntoPatches(scan, volume.patch());
      if (surface.mesh.empty()) {
        volume.Integrate(scan, patches);
        continue;
      }
      const perception::RegisteredScan placed = perception::RegisterScan(
          std::move(scan), std::move(patches), surface, voxel, registering);
      if (placed.registration.accepted) {
        volume.Integrate(placed.scan, placed.patches);
      } else {
        ++refused;
      }
      seconds += watch.Seconds();
    }
  }
  const world::PartialMesh all = volume.Extract();
  const world::PartialMesh object = perception::Above(all, TableIn(all, subject), kFoot);
  const SurfaceFigures figures = CompareSurface(SpreadOver(object.mesh, kSpacing, 1), truth);
  return {{"scans", taken},
          {"refused", refused},
          {"points_a_scan", taken > 0 ? points / static_cast<std::size_t>(taken) : 0},
          {"seconds_a_scan", taken > 0 ? seconds / taken : 0.0},
          {"reachable_within_1mm", figures.reachable_within_1mm},
          {"reachable_within_3mm", figures.reachable_within_3mm},
          {"all_within_1mm", figures.all_within_1mm},
          {"rms", figures.rms}};
}

Json RunTrial(const sim::SceneObject& object, std::uint64_t seed) {
  FreeCamera camera(OnPedestal(object), seed);
  const Subject subject = SubjectOf(camera.world());
  const sim::PlacedObject& placed = camera.world().objects().at(0);
  const std::vector<SurfacePoint> truth =
      ReachableSurface(placed.mesh, placed.X_WM, camera.world().scene().table.height, kTruePoints,
                       ForkSeed(seed, "truth"));
  Rng striper_rng(ForkSeed(seed, "striper"));
  Rng camera_rng(ForkSeed(seed, "hand camera"));
  const DepthScans depth(subject, &camera, &camera_rng);
  Json trial;
  trial["object"] = object.name;
  trial["striper"] = Measure(StriperScans(subject, seed), 0.001, subject, truth, &striper_rng);
  trial["camera"] = Measure(depth, 0.002, subject, truth, &camera_rng);
  return trial;
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  const auto all = [&](const char* sensor, const char* key) {
    std::vector<double> values;
    for (const Json& trial : trials) values.push_back(trial.at(sensor).at(key).get<double>());
    return values;
  };
  const auto both = [&](const std::string& metric, const char* key, std::optional<double> paper,
                        std::optional<double> camera_paper) {
    const Estimate camera = Mean(all("camera", key));
    return std::vector<Row>{{"striper: " + metric, Mean(all("striper", key)), paper, camera.value},
                            {"camera: " + metric, camera, camera_paper}};
  };
  std::vector<Row> rows;
  for (const auto& some :
       {both("share of the reachable surface within 1 mm", "reachable_within_1mm", 0.981, 0.741),
        both("… within 3 mm", "reachable_within_3mm", {}, {}),
        both("share of the whole surface within 1 mm", "all_within_1mm", {}, {}),
        both("RMS error [m]", "rms", 0.00215, 0.0106), both("scans", "scans", {}, {}),
        both("scans that could not be registered", "refused", {}, {})}) {
    rows.insert(rows.end(), some.begin(), some.end());
  }
  return rows;
}

}  // namespace

void RunSensorsExperiment(const ExperimentOptions& options) {
  const Repertoire repertoire = LoadRepertoire(options.models, options.unfamiliar);
  std::vector<sim::SceneObject> objects = repertoire.known;
  objects.insert(objects.end(), repertoire.unknown.begin(), repertoire.unknown.end());
  RunTrials(
      "sensors", options,
      [&](int t) {
        const auto& object = objects[static_cast<std::size_t>(t) % objects.size()];
        return RunTrial(object, ForkSeed(options.seed, fmt::format("sensors {}", t)));
      },
      Summarise);
}

}  // namespace secondlook::apps
