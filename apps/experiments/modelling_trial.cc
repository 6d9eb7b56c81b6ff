#include "apps/experiments/modelling_trial.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "apps/experiments/single_view.h"
#include "lib/common/error.h"
#include "lib/common/parallel.h"
#include "lib/geometry/kd_tree.h"
#include "lib/geometry/point_to_plane.h"
#include "lib/geometry/ray_caster.h"
#include "lib/geometry/sampling.h"
#include "lib/perception/coverage.h"
#include "lib/perception/register_scan.h"
#include "lib/planning/boundary_search.h"
#include "lib/planning/scan_gain.h"
#include "lib/world/bayes_update.h"
#include "lib/world/scan_patches.h"
#include "lib/world/surface_volume.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;
const double kGolden = std::numbers::pi * (3.0 - std::sqrt(5.0));

// The robot.
constexpr double kDistance = 0.62;    ///< From the camera to the surface [m]: it measures from 0.5.
constexpr double kClearance = 0.08;   ///< Of the camera from the table [m].
constexpr double kSpeed = 0.25;       ///< Of the camera around the object [m/s].
constexpr double kScanSeconds = 1.0;  ///< To settle and take a frame.
constexpr double kPlanSeconds = 0.3;  ///< Charged for planning, whoever plans.

// The model.
constexpr double kVoxel = 0.003;    ///< Of the surface [m].
constexpr double kMapVoxel = 0.01;  ///< Of the voxel space [m].
constexpr double kRegion = 0.4;     ///< Edge of the box around the first cluster [m].
constexpr double kStands = 0.003;   ///< Lower is the table [m].
constexpr double kFooting = 0.008;  ///< A border lower than this is where it stands [m].

// The truth.
constexpr int kSamples = 6000;
constexpr int kReachPoses = 2000;
constexpr double kMaxIncidence = 80.0 * kDegree;  ///< As the simulated camera.
constexpr double kNear = 0.004;  ///< A true point so near to the model is in it [m].

sim::Scene OnTable(sim::SceneObject object, double yaw_deg) {
  sim::Scene scene;
  scene.name = "modelling";
  scene.table.size = {0.9, 0.9};
  scene.walls.emplace();
  object.position = {0.0, 0.0};
  object.yaw_deg = yaw_deg;
  scene.objects.push_back(std::move(object));
  return scene;
}

/// Places all around `target_W` at `distance`, evenly over the sphere as far as they stand clear of
/// the table.
std::vector<Pose> Around(const Vector3d& target_W, double table, int count, double distance) {
  const double lowest = (table + kClearance - target_W.z()) / distance;
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    const double up = std::max(lowest, 0.0) + (0.995 - std::max(lowest, 0.0)) * (i + 0.5) / count;
    const double level = std::sqrt(1.0 - up * up);
    const Vector3d way(level * std::cos(kGolden * i), level * std::sin(kGolden * i), up);
    poses.push_back(LookAt(target_W + distance * way, target_W));
  }
  return poses;
}

/// A view of a ring, evenly around at 35 degrees, the next round at 60.
Pose OnRing(const Vector3d& target_W, double azimuth, int k) {
  constexpr int kPerRing = 8;
  const double elevation = (k / kPerRing % 2 == 0 ? 35.0 : 60.0) * kDegree;
  const double a = azimuth + 2.0 * std::numbers::pi * (k + 0.5 * (k / kPerRing)) / kPerRing;
  return LookAt(
      target_W + kDistance * Vector3d(std::cos(elevation) * std::cos(a),
                                      std::cos(elevation) * std::sin(a), std::sin(elevation)),
      target_W);
}

/// The way around the object, not through it.
double MoveSeconds(const Vector3d& middle_W, const Pose& X_WA, const Pose& X_WB) {
  const Vector3d a = X_WA.translation() - middle_W;
  const Vector3d b = X_WB.translation() - middle_W;
  const double angle = std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
  return angle * std::max(a.norm(), b.norm()) / kSpeed;
}

Pose SmallMotion(double sigma, double sigma_deg, Rng* rng) {
  const auto draw = [&](double s) {
    return Vector3d(rng->Gaussian(s), rng->Gaussian(s), rng->Gaussian(s));
  };
  Pose X = Pose::Identity();
  X.linear() = RotationFromVector(draw(sigma_deg * kDegree));
  X.translation() = draw(sigma);
  return X;
}

world::RangeScan ScanOf(const cv::Mat& depth, const geometry::CameraModel& camera, const Pose& X_WC,
                        const Eigen::AlignedBox3d& box_W, const sim::NoiseConfig& noise) {
  world::RangeScan scan;
  for (const Eigen::Vector3f& p_CP : geometry::Deproject(depth, camera).points_C) {
    if (!geometry::IsMeasured(p_CP)) continue;
    const Vector3d p_WP = X_WC * p_CP.cast<double>();
    if (!box_W.contains(p_WP)) continue;
    scan.points_W.push_back(p_WP);
    scan.sigmas.push_back(static_cast<float>(geometry::DepthSigma(p_CP.z())));
  }
  scan.lines = {{X_WC.translation(), static_cast<int>(scan.points_W.size())}};
  // The first scan erred as well, and defines the map; what is fixed to the camera errs to the
  // other side from there.
  scan.position_sigma =
      std::hypot(std::numbers::sqrt2 * noise.arm_sigma, 2.0 * noise.hand_eye_sigma);
  scan.rotation_sigma = kDegree * std::hypot(std::numbers::sqrt2 * noise.arm_sigma_deg,
                                             2.0 * noise.hand_eye_sigma_deg);
  return scan;
}

/// The pose that brings the model to the truth (a rigid alignment, point to plane).
Pose Align(const world::PartialMesh& model, const geometry::KdTree& tree,
           const std::vector<Vector3d>& normals_W) {
  constexpr int kMost = 1500;
  constexpr double kGate = 0.015;  // [m]
  const std::size_t stride = 1 + model.mesh.vertices.size() / kMost;
  Pose X = Pose::Identity();
  for (int iteration = 0; iteration < 10; ++iteration) {
    std::vector<geometry::PointPlanePair> pairs;
    for (std::size_t i = 0; i < model.mesh.vertices.size(); i += stride) {
      const Vector3d p = X * model.mesh.vertices[i].cast<double>();
      const auto nearest = tree.Nearest(p, kGate);
      if (!nearest) continue;
      const Vector3d& normal = normals_W[nearest->index];
      if (normal.dot(X.linear() * model.normals[i].cast<double>()) < 0.5) continue;
      pairs.push_back({p, tree.points()[nearest->index], normal, 1.0});
    }
    X = geometry::SolvePointToPlane(pairs).X * X;
  }
  return X;
}

/// What is known of the object so far.
struct Model {
  world::SupportPlane plane_W;
  world::SurfaceVolume volume;
  world::BrickGrid grid;
  world::LeapField leaps;
  world::PartialMesh all;      ///< With the table around.
  world::PartialMesh surface;  ///< Of the object.
};

Model StartModel(const CutPhoto& cut, const Pose& X_WC) {
  const auto largest = std::max_element(
      cut.clusters.begin(), cut.clusters.end(),
      [](const auto& a, const auto& b) { return a.pixels.size() < b.pixels.size(); });
  const Vector3d center_W = X_WC * largest->center_C;
  const Vector3d half = Vector3d::Constant(0.5 * kRegion);
  const Eigen::AlignedBox3d box_W(center_W - half, center_W + half);
  return {world::Transform(X_WC, cut.view.plane_C),
          world::SurfaceVolume({.voxel_m = kVoxel}, box_W),
          world::BrickGrid(kMapVoxel, box_W),
          {},
          {},
          {}};
}

/// Returns why its registration was refused; empty when it was not.
std::string AddScan(const Photo& photo, const geometry::CameraModel& camera,
                    const Pose& nominal_X_WC, const sim::NoiseConfig& noise, Model* model) {
  world::RangeScan scan =
      ScanOf(photo.frame.depth, camera, nominal_X_WC, model->volume.box_W(), noise);
  if (scan.empty()) return "it shows nothing";
  world::ScanPatches patches = world::CutIntoPatches(scan, model->volume.patch());
  Pose X_WC = nominal_X_WC;
  if (!model->all.mesh.empty()) {
    perception::RegisteredScan registered =
        perception::RegisterScan(std::move(scan), std::move(patches), model->all, kVoxel,
                                 perception::ScanRegisterConfig(kVoxel));
    if (!registered.registration.accepted) return registered.registration.reason;
    scan = std::move(registered.scan);
    patches = std::move(registered.patches);
    Pose nominal = Pose::Identity();
    nominal.translation() = nominal_X_WC.translation();
    X_WC = registered.registration.X_WC * nominal.inverse() * nominal_X_WC;
  }
  model->volume.Integrate(scan, patches);
  world::DepthUpdate update;
  update.stride = 2;
  world::EnterDepth(photo.frame.depth, camera, X_WC, update, &model->grid);
  model->leaps.Refresh(model->grid);
  model->all = model->volume.Extract();
  model->surface = perception::Above(model->all, model->plane_W, kStands);
  return {};
}

/// A next scan, and what part of the model's surface it was expected to add.
struct Choice {
  Pose X_WC;
  double gain{};
};

std::optional<Choice> Choose(const std::string& planner, const Model& model, int scans,
                             const Pose& X_WC, const Vector3d& middle_W,
                             const geometry::CameraModel& camera, Rng* rng) {
  planning::BoundarySearchConfig search;
  search.distance_m = kDistance;
  search.clearance_m = kClearance;
  search.footing_m = kFooting;
  const planning::ScanGainConfig config;
  const std::vector<planning::SurfaceTrend> trends =
      planning::FindTrends(model.surface, model.plane_W, search);
  const std::vector<planning::ScanCandidate> candidates =
      planning::CandidateScans(trends, model.grid, model.leaps, model.plane_W, search);
  std::vector<Pose> poses;
  for (const planning::ScanCandidate& candidate : candidates) {
    poses.push_back(candidate.X_WC);
  }
  const bool ours = planner == "ours";
  if (poses.empty() || ours) {
    const double table = model.plane_W.offset;
    for (const Pose& pose : Around(middle_W, table, 60, kDistance)) poses.push_back(pose);
  }
  if (planner == "boundary only" && !candidates.empty()) {
    std::vector<int> longest;
    double length = 0.0;
    for (int i = 0; i < static_cast<int>(candidates.size()); ++i) {
      const double border = trends[candidates[i].trend].border;
      if (border > length) longest.clear();
      length = std::max(length, border);
      if (border == length) longest.push_back(i);
    }
    return Choice{poses[longest[rng->Index(static_cast<int>(longest.size()))]], 0.0};
  }

  const planning::ScanGainField field(model.grid, model.surface, trends, model.plane_W, config);
  std::vector<planning::ScanGain> gains(poses.size());
  const geometry::CameraModel small = camera.Scaled(0.25);
  ParallelFor(static_cast<int>(poses.size()),
              [&](int i) { gains[i] = field.Measure(small, poses[i]); });
  std::vector<double> scores;
  if (planner == "Kriegel") {
    scores = planning::KriegelUtilities(gains, scans, config);
  } else {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double seconds = kScanSeconds + kPlanSeconds + MoveSeconds(middle_W, X_WC, poses[i]);
      scores.push_back(ours ? gains[i].new_surface / seconds : gains[i].entropy);
    }
  }
  const auto best = std::max_element(scores.begin(), scores.end()) - scores.begin();
  const double filled = perception::EstimateCoverage(model.surface, model.plane_W, kFooting).filled;
  return Choice{poses[best], ours && filled > 0.0 ? gains[best].new_surface / filled : 0.0};
}

}  // namespace

ModellingTrial::ModellingTrial(sim::SceneObject object, std::uint64_t seed)
    : seed_(seed),
      camera_(OnTable(std::move(object), Rng(ForkSeed(seed, "yaw")).Uniform(-180.0, 180.0)), seed) {
  const sim::PlacedObject& placed = camera_.world().objects().front();
  const double table = camera_.world().scene().table.height;
  Eigen::AlignedBox3d box_W;
  for (const Eigen::Vector3f& vertex : placed.mesh.vertices) {
    box_W.extend(placed.X_WM * vertex.cast<double>());
  }
  middle_W_ = box_W.center();

  // What any pose around sees of the surface.
  Rng rng(ForkSeed(seed, "truth"));
  const geometry::RayCaster caster(placed.mesh);
  const std::vector<geometry::MeshSample> samples =
      geometry::SampleSurface(placed.mesh, kSamples, &rng);
  std::vector<Vector3d> from_W;
  for (const Pose& pose : Around(middle_W_, table, kReachPoses, kDistance)) {
    from_W.push_back(pose.translation());
  }
  const Pose X_MW = placed.X_WM.inverse();
  truth_.reachable.assign(samples.size(), 0);
  for (const geometry::MeshSample& sample : samples) {
    truth_.points_W.push_back(placed.X_WM * sample.surface.point.cast<double>());
    truth_.normals_W.push_back(placed.X_WM.linear() * sample.surface.normal.cast<double>());
  }
  const double min_cosine = std::cos(kMaxIncidence);
  const double min_depth = camera_.info().min_depth;
  int reachable = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Vector3d& p_W = truth_.points_W[i];
    // In an order of its own for each point: neighbours in the list look from far apart.
    for (int k = 0; k < kReachPoses && truth_.reachable[i] == 0; ++k) {
      const Vector3d& p_WC = from_W[(k * 617) % kReachPoses];
      const Vector3d way = p_WC - p_W;
      if (way.norm() < min_depth) continue;
      // The side that is lit: meshes are not always wound alike.
      if (std::abs(way.normalized().dot(truth_.normals_W[i])) < min_cosine) continue;
      const Vector3d start_W = p_W + 1e-4 * way.normalized();
      const geometry::Ray ray{(X_MW * start_W).cast<float>(),
                              (X_MW.linear() * (p_WC - start_W)).cast<float>()};
      const geometry::RayHit hit = caster.Cast({&ray, 1}).front();
      if (hit.triangle < 0 || hit.distance > 1.0F) truth_.reachable[i] = 1;
    }
    reachable += truth_.reachable[i];
  }
  reachable_share_ = static_cast<double>(reachable) / kSamples;
}

std::vector<ModelledScan> ModellingTrial::Follow(const std::string& planner, int scans) {
  if (std::find(kScanPlanners.begin(), kScanPlanners.end(), planner) == kScanPlanners.end()) {
    Throw<InvalidArgument>("modelling: there is no planner '{}'", planner);
  }
  const sim::NoiseConfig& noise = camera_.world().noise();
  const double table = camera_.world().scene().table.height;
  Rng fixed(ForkSeed(seed_, "hand-eye"));
  const Pose X_CCm = SmallMotion(noise.hand_eye_sigma, noise.hand_eye_sigma_deg, &fixed);
  const double azimuth = fixed.Uniform(-std::numbers::pi, std::numbers::pi);
  Rng chance(ForkSeed(seed_, planner));
  const std::vector<Pose> anywhere = Around(middle_W_, table, kReachPoses, kDistance);
  const geometry::KdTree tree(truth_.points_W);

  std::optional<Model> model;
  std::vector<ModelledScan> course;
  Pose X_WC = OnRing(middle_W_, azimuth, 0);
  ModelledScan now;
  for (int k = 0; k < scans; ++k) {
    if (k > 0) {
      std::optional<Choice> choice;
      if (planner == "random views" || !model) {
        choice = Choice{anywhere[chance.Index(kReachPoses)], 0.0};
      } else if (planner == "uniform ring") {
        choice = Choice{OnRing(middle_W_, azimuth, k), 0.0};
      } else {
        choice = Choose(planner, *model, k, X_WC, middle_W_, camera_.info().model, &chance);
      }
      if (!choice) break;
      now.seconds += kPlanSeconds + MoveSeconds(middle_W_, X_WC, choice->X_WC);
      now.gain = choice->gain;
      X_WC = choice->X_WC;
    }
    Rng errors(ForkSeed(seed_, fmt::format("scan {}", k)));
    const Pose nominal_X_WC =
        X_WC * X_CCm * SmallMotion(noise.arm_sigma, noise.arm_sigma_deg, &errors);
    const Photo photo = camera_.Take(X_WC, &errors);
    now.seconds += kScanSeconds;
    if (!model) {
      const std::optional<CutPhoto> cut = Cut(photo, camera_.info().model);
      if (cut && !cut->clusters.empty()) model = StartModel(*cut, nominal_X_WC);
    }
    if (model) {
      now.refused = AddScan(photo, camera_.info().model, nominal_X_WC, noise, &*model);
      const world::PartialMesh& surface = model->surface;
      const perception::Coverage coverage =
          perception::EstimateCoverage(surface, model->plane_W, kFooting);
      now.estimated = coverage.Estimated();
      now.estimated_reached = coverage.Reachable();
      if (!surface.mesh.empty()) {
        const Pose X = Align(surface, tree, truth_.normals_W);
        std::vector<Vector3d> vertices_W;
        double squares = 0.0;
        double density = 0.0;
        for (std::size_t i = 0; i < surface.mesh.vertices.size(); ++i) {
          vertices_W.push_back(X * surface.mesh.vertices[i].cast<double>());
          const auto nearest = tree.Nearest(vertices_W.back(), 1).front();
          const double off = truth_.normals_W[nearest.index].dot(vertices_W.back() -
                                                                 truth_.points_W[nearest.index]);
          squares += off * off;
          density += surface.density[i];
        }
        const auto count = static_cast<double>(vertices_W.size());
        now.rms = std::sqrt(squares / count);
        now.density = density / count;
        const geometry::KdTree have(vertices_W);
        int reached = 0;
        int reachable = 0;
        int whole = 0;
        for (std::size_t i = 0; i < truth_.points_W.size(); ++i) {
          const bool in_it = have.Nearest(truth_.points_W[i], kNear).has_value();
          whole += in_it ? 1 : 0;
          reached += in_it && truth_.reachable[i] != 0 ? 1 : 0;
          reachable += truth_.reachable[i];
        }
        now.reached = static_cast<double>(reached) / std::max(reachable, 1);
        now.whole = static_cast<double>(whole) / static_cast<double>(truth_.points_W.size());
      }
    }
    course.push_back(now);
  }
  return course;
}

}  // namespace secondlook::apps
