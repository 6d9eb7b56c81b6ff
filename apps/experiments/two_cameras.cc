#include "apps/experiments/two_cameras.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "apps/appearance.h"
#include "apps/experiments/free_camera.h"
#include "apps/experiments/random_scene.h"
#include "apps/mission_config.h"
#include "lib/common/hash.h"
#include "lib/common/parallel.h"
#include "lib/perception/background.h"
#include "lib/perception/segment.h"
#include "sim/fixtures.h"
#include "sim/noise.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kOccluders = 3;
constexpr int kBackgroundFrames = 15;
/// How much wider than a crowded table one is where a colour camera sees things apart.
constexpr double kSpread = 1.4;
/// Things of which a view shows fewer pixels cannot be recognised.
constexpr int kMinSide_px = 12;
constexpr int kTrainingTables = 6;
constexpr int kViewsOfATable = 14;

// Neither table nor lamp is in both lists: what is learnt in one room is tested in another.
const std::array<Vector3d, 4> kTestTables{
    {{0.62, 0.47, 0.32}, {0.35, 0.38, 0.42}, {0.7, 0.7, 0.66}, {0.3, 0.42, 0.34}}};
const std::array<Vector3d, 6> kTrainingColors{{{0.5, 0.35, 0.22},
                                               {0.55, 0.55, 0.58},
                                               {0.8, 0.76, 0.7},
                                               {0.25, 0.28, 0.3},
                                               {0.45, 0.5, 0.6},
                                               {0.6, 0.42, 0.45}}};

// Nor is a colour of obstacles.
const std::array<Vector3d, 4> kTestBoxes{
    {{0.15, 0.3, 0.5}, {0.75, 0.7, 0.3}, {0.55, 0.2, 0.2}, {0.2, 0.45, 0.3}}};
const std::array<Vector3d, 4> kTrainingBoxes{
    {{0.5, 0.5, 0.5}, {0.85, 0.8, 0.75}, {0.3, 0.25, 0.2}, {0.6, 0.45, 0.6}}};

/// A lamp between the azimuths `from` and `to` [rad], at `height` or up to 0.6 m higher, and some
/// light from everywhere.
void DrawLight(double from, double to, double height, sim::Scene* scene, Rng* rng) {
  const double azimuth = rng->Uniform(from, to);
  sim::Light light;
  light.position = {1.3 * std::cos(azimuth), 1.3 * std::sin(azimuth),
                    height + rng->Uniform(0.0, 0.6)};
  light.intensity = rng->Uniform(0.6, 0.9);
  light.color = {1.0, rng->Uniform(0.92, 1.0), rng->Uniform(0.85, 1.0)};
  scene->lights = {light};
  scene->ambient = rng->Uniform(0.3, 0.45);
}

/// A camera `distance` from the middle of the table, `elevation` above it.
Pose Around(const sim::Table& table, double azimuth, double elevation, double distance) {
  const Vector3d target(table.position.x(), table.position.y(), table.height + 0.04);
  const Vector3d towards(std::cos(elevation) * std::cos(azimuth),
                         std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  return LookAt(target + distance * towards, target);
}

struct Places {
  Pose X_WHead;
  Pose X_WHand;
};

Places DrawPlaces(const sim::Table& table, std::uint64_t seed) {
  Rng rng(ForkSeed(seed, "places"));
  const double azimuth = rng.Uniform(-std::numbers::pi, std::numbers::pi);
  const double side = rng.Index(2) == 0 ? 1.0 : -1.0;
  Places places;
  places.X_WHead = Around(table, azimuth, rng.Uniform(20.0, 35.0) * kDegree, rng.Uniform(1.3, 1.6));
  places.X_WHand = Around(table, azimuth + side * rng.Uniform(50.0, 110.0) * kDegree,
                          rng.Uniform(55.0, 70.0) * kDegree, rng.Uniform(1.1, 1.2));
  return places;
}

/// `X` as calibration and encoders have it.
Pose Believed(const Pose& X, double sigma_m, double sigma_deg, Rng* rng) {
  Pose believed = X;
  const auto vector = [&](double sigma) {
    return Vector3d(rng->Gaussian(sigma), rng->Gaussian(sigma), rng->Gaussian(sigma));
  };
  believed.translation() += vector(sigma_m);
  believed.linear() = X.linear() * RotationFromVector(vector(sigma_deg * kDegree));
  return believed;
}

/// The object of which most of the pixels are; -1 when most are of none.
int MostlyShows(const world::Cluster& cluster, const cv::Mat& ids) {
  std::map<int, int> counts;
  for (const int pixel : cluster.pixels) {
    ++counts[ids.at<std::uint16_t>(pixel / ids.cols, pixel % ids.cols)];
  }
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return most->first >= sim::kFirstObjectId && most->first < sim::kTableId
             ? most->first - sim::kFirstObjectId
             : -1;
}

/// Of those that are large enough to be told.
std::vector<Sighted> Classify(const std::vector<world::Cluster>& clusters, const cv::Mat& color,
                              const cv::Mat& ids, const perception::Classifier& classifier) {
  std::vector<Sighted> sighted;
  for (const world::Cluster& cluster : clusters) {
    sighted.push_back(
        {MostlyShows(cluster, ids), classifier.Classify(color(BoundingBox(cluster, color.cols)))});
  }
  return sighted;
}

void LeaveOutSmall(int image_width, std::vector<world::Cluster>* clusters) {
  std::erase_if(*clusters, [&](const world::Cluster& cluster) {
    const cv::Rect box = BoundingBox(cluster, image_width);
    return std::min(box.width, box.height) < kMinSide_px;
  });
}

/// What stands on the table. What touches stays one: only recognition by shape could tell where one
/// thing ends.
std::vector<world::Cluster> CutByDepth(const Photo& photo, const geometry::CameraModel& model) {
  UnderstandingConfig config;
  config.segment.split_touching = false;
  const Vector3d up_C = photo.X_WC.linear().transpose() * Vector3d::UnitZ();
  std::vector<world::Cluster> clusters =
      perception::Segment(geometry::Deproject(photo.frame.depth, model), up_C, config.segment,
                          photo.X_WC.translation().z() - config.floor_clearance_m)
          .clusters;
  LeaveOutSmall(model.width, &clusters);
  return clusters;
}

/// The colour camera in the hand.
class HandCamera {
 public:
  HandCamera(const sim::World& world, const geometry::CameraModel& model)
      : world_(world), renderer_(world, model) {}

  sim::Render Clean(const Pose& X_WC) { return renderer_.Draw(X_WC, world_.StateAt(world_.Now())); }
  cv::Mat Color(const sim::Render& clean, Rng* rng) const {
    return sim::ColorNoise(clean, world_.noise(), rng);
  }

 private:
  const sim::World& world_;
  sim::SceneRenderer renderer_;
};

/// What the hand sees of the table before anything is on it.
perception::BackgroundModel LearnBackground(sim::Scene scene, const geometry::CameraModel& model,
                                            const Pose& X_WHand, std::uint64_t seed, Rng* rng) {
  scene.objects.clear();
  scene.boxes.clear();
  const FreeCamera empty(scene, seed);
  HandCamera camera(empty.world(), model);
  const sim::Render clean = camera.Clean(X_WHand);
  std::vector<cv::Mat> frames;
  for (int i = 0; i < kBackgroundFrames; ++i) frames.push_back(camera.Color(clean, rng));
  return {frames, X_WHand};
}

/// The smallest box around the pixels of `id`; empty where there are none.
cv::Rect BoxOf(int id, const cv::Mat& ids) {
  cv::Mat points;
  cv::findNonZero(ids == id, points);
  return points.empty() ? cv::Rect() : cv::boundingRect(points);
}

/// What is left when something hides a side of it.
cv::Rect Part(const cv::Rect& box, Rng* rng) {
  cv::Rect part = box;
  const bool upright = rng->Index(2) == 0;
  int& length = upright ? part.height : part.width;
  int& begin = upright ? part.y : part.x;
  const int hidden = static_cast<int>(length * rng->Uniform(0.2, 0.5));
  if (rng->Index(2) == 0) begin += hidden;
  length -= hidden;
  return part;
}

/// As if taken from up to twice as far.
cv::Mat FromFarther(const cv::Mat& crop, Rng* rng) {
  const int least = std::min(crop.cols, crop.rows);
  const double scale = std::max(rng->Uniform(0.5, 1.0), static_cast<double>(kMinSide_px) / least);
  cv::Mat shrunk;
  cv::resize(crop, shrunk, {}, scale, scale, cv::INTER_AREA);
  return shrunk;
}

/// Crops of what has `id` in `scene`, from random sides and distances.
std::vector<cv::Mat> Crops(const sim::Scene& scene, int id, std::uint64_t seed) {
  FreeCamera camera(scene, seed);
  Rng rng(ForkSeed(seed, "crops"));
  HandCamera eye(camera.world(), camera.info().model);
  const Vector3d target(0.0, 0.0, scene.table.height + 0.06);
  std::vector<cv::Mat> crops;
  for (int i = 0; i < kViewsOfATable; ++i) {
    const sim::Render clean = eye.Clean(DrawViewOf(target, &rng));
    const cv::Mat color = eye.Color(clean, &rng);
    const cv::Rect box = BoxOf(id, clean.id);
    if (std::min(box.width, box.height) < 2 * kMinSide_px) continue;
    crops.push_back(FromFarther(color(box), &rng));
    if (i % 2 == 0) crops.push_back(FromFarther(color(Part(box, &rng)), &rng));
  }
  return crops;
}

sim::Scene TrainingTable(int number, std::uint64_t seed) {
  Rng rng(ForkSeed(seed, fmt::format("training table {}", number)));
  sim::Scene scene;
  scene.table.size = {0.8, 0.6};
  scene.table.color = kTrainingColors[static_cast<std::size_t>(number)];
  scene.walls.emplace();
  DrawLight(0.0, std::numbers::pi, 1.6, &scene, &rng);
  return scene;
}

/// A box on the table in one of `colors`.
sim::SceneBox DrawBox(const Vector3d& size, const std::array<Vector3d, 4>& colors,
                      const sim::Table& table, Rng* rng) {
  sim::SceneBox box;
  box.size = size;
  box.color = colors[static_cast<std::size_t>(rng->Index(static_cast<int>(colors.size())))];
  box.position.z() = table.height;
  return box;
}

/// The boxes around the objects of `scene`.
std::vector<Eigen::AlignedBox3d> BoxesAround(const sim::Scene& scene) {
  std::vector<Eigen::AlignedBox3d> boxes_W;
  for (const sim::PlacedObject& thing : sim::PlaceObjects(scene)) {
    Eigen::AlignedBox3d box_W;
    for (const Eigen::Vector3f& p_MV : thing.mesh.vertices) {
      box_W.extend(thing.X_WM * p_MV.cast<double>());
    }
    boxes_W.push_back(box_W);
  }
  return boxes_W;
}

/// An upright board in one of `colors`, 35 mm clear of what is in `box_W`, that hides most of it
/// from the side `towards` (level, of length 1).
sim::SceneBox DrawOccluder(const Eigen::AlignedBox3d& box_W, const Vector3d& towards,
                           const std::array<Vector3d, 4>& colors, const sim::Table& table,
                           Rng* rng) {
  const Vector3d size = box_W.sizes();
  const double reach = 0.5 * size.head<2>().maxCoeff();
  sim::SceneBox occluder = DrawBox(
      {0.02, std::max(0.03, 0.8 * 2.0 * reach), std::max(0.03, rng->Uniform(0.6, 0.9) * size.z())},
      colors, table, rng);
  occluder.position.head<2>() = (box_W.center() + (reach + 0.035) * towards).head<2>();
  occluder.yaw_deg = std::atan2(towards.y(), towards.x()) / kDegree;
  return occluder;
}

/// `scene` with boards on so many random sides of its one object.
sim::Scene Hemmed(sim::Scene scene, int boards, Rng* rng) {
  const Eigen::AlignedBox3d box_W = BoxesAround(scene).front();
  double azimuth = rng->Uniform(-std::numbers::pi, std::numbers::pi);
  for (int i = 0; i < boards; ++i) {
    scene.boxes.push_back(DrawOccluder(box_W, {std::cos(azimuth), std::sin(azimuth), 0.0},
                                       kTrainingBoxes, scene.table, rng));
    azimuth += rng->Uniform(0.5, 1.5) * std::numbers::pi;
  }
  return scene;
}

/// `scene` with `thing` near the middle of its table.
sim::Scene With(sim::SceneObject thing, sim::Scene scene, Rng* rng) {
  thing.position = {rng->Uniform(-0.1, 0.1), rng->Uniform(-0.1, 0.1)};
  thing.yaw_deg = rng->Uniform(-180.0, 180.0);
  scene.objects.push_back(std::move(thing));
  return scene;
}

/// Crops of `thing` on `table`, alone and behind boards.
std::vector<cv::Mat> CropsOf(const sim::SceneObject& thing, const sim::Scene& table,
                             std::uint64_t seed) {
  Rng rng(seed);
  const sim::Scene alone = With(thing, table, &rng);
  std::vector<cv::Mat> crops = Crops(alone, sim::kFirstObjectId, seed);
  const std::vector<cv::Mat> hidden =
      Crops(Hemmed(alone, 2, &rng), sim::kFirstObjectId, ForkSeed(seed, "hemmed"));
  crops.insert(crops.end(), hidden.begin(), hidden.end());
  return crops;
}

/// Crops of what is none of `things`: a box alone, and a board beside one of them.
std::vector<cv::Mat> CropsOfBackground(const std::vector<sim::SceneObject>& things,
                                       const sim::Scene& table, std::uint64_t seed) {
  Rng rng(seed);
  sim::Scene alone = table;
  alone.boxes.push_back(
      DrawBox({rng.Uniform(0.02, 0.1), rng.Uniform(0.03, 0.15), rng.Uniform(0.03, 0.15)},
              kTrainingBoxes, table.table, &rng));
  std::vector<cv::Mat> crops = Crops(alone, sim::kBoxId, seed);
  const sim::SceneObject& thing =
      things[static_cast<std::size_t>(rng.Index(static_cast<int>(things.size())))];
  const std::vector<cv::Mat> boards =
      Crops(Hemmed(With(thing, table, &rng), 1, &rng), sim::kBoxId, ForkSeed(seed, "hemmed"));
  crops.insert(crops.end(), boards.begin(), boards.end());
  return crops;
}

}  // namespace

sim::Scene DrawTestTable(const std::vector<sim::SceneObject>& things, std::uint64_t seed) {
  Rng rng(ForkSeed(seed, "test table"));
  sim::Scene scene = DrawCrowdedTable(things, &rng);
  scene.table.size *= kSpread;
  for (sim::SceneObject& thing : scene.objects) {
    for (double& coordinate : thing.position) coordinate *= kSpread;
  }
  scene.table.color =
      kTestTables[static_cast<std::size_t>(rng.Index(static_cast<int>(kTestTables.size())))];
  DrawLight(-std::numbers::pi, 0.0, 2.3, &scene, &rng);
  return scene;
}

sim::Scene WithOccluders(sim::Scene scene, const Vector3d& p_WEye, int count, std::uint64_t seed) {
  Rng rng(ForkSeed(seed, "occluders"));
  const std::vector<Eigen::AlignedBox3d> boxes_W = BoxesAround(scene);
  std::vector<std::size_t> order(boxes_W.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[static_cast<std::size_t>(rng.Index(static_cast<int>(i)))]);
  }
  for (const std::size_t hidden : order) {
    if (std::ssize(scene.boxes) == count) break;
    const Eigen::AlignedBox3d& box_W = boxes_W[hidden];
    Vector3d towards = p_WEye - box_W.center();
    towards.z() = 0.0;
    towards.normalize();
    sim::SceneBox occluder = DrawOccluder(box_W, towards, kTestBoxes, scene.table, &rng);
    occluder.name = fmt::format("occluder {}", scene.boxes.size() + 1);
    const Vector3d& center = occluder.position;
    const double room = 0.5 * occluder.size.y() + 0.01;
    const Eigen::AlignedBox3d around(
        Vector3d(center.x() - room, center.y() - room, scene.table.height),
        Vector3d(center.x() + room, center.y() + room, scene.table.height + 1.0));
    bool free = scene.table.Contains(center.head<2>());
    for (std::size_t i = 0; i < boxes_W.size(); ++i) {
      if (i != hidden && boxes_W[i].intersects(around)) free = false;
    }
    if (free) scene.boxes.push_back(occluder);
  }
  return scene;
}

sim::Scene WithOccluders(sim::Scene scene, std::uint64_t seed) {
  const Vector3d p_WHead = DrawPlaces(scene.table, seed).X_WHead.translation();
  return WithOccluders(std::move(scene), p_WHead, kOccluders, seed);
}

TwoViews LookTwice(const sim::Scene& scene, const perception::Classifier& classifier,
                   std::uint64_t seed) {
  const Places places = DrawPlaces(scene.table, seed);
  Rng rng(ForkSeed(seed, "look twice"));
  FreeCamera camera(scene, seed);
  const geometry::CameraModel& model = camera.info().model;
  const Photo photo = camera.Take(places.X_WHead);
  TwoViews views;
  std::vector<world::Cluster> seen = CutByDepth(photo, model);
  views.head = Classify(seen, photo.frame.color, photo.id, classifier);

  HandCamera hand(camera.world(), model);
  const sim::Render clean = hand.Clean(places.X_WHand);
  const cv::Mat color = hand.Color(clean, &rng);
  std::vector<world::Cluster> boxed = LearnBackground(scene, model, places.X_WHand, seed, &rng)
                                          .Detect(color, {}, model, places.X_WHand)
                                          .clusters;
  LeaveOutSmall(model.width, &boxed);
  views.hand = Classify(boxed, color, clean.id, classifier);

  const sim::NoiseConfig& noise = camera.world().noise();
  const Pose X_WHead =
      Believed(places.X_WHead, noise.extrinsics_sigma,
               std::hypot(noise.extrinsics_sigma_deg, noise.pan_tilt_sigma_deg), &rng);
  const Pose X_WHand = Believed(places.X_WHand, std::hypot(noise.hand_eye_sigma, noise.arm_sigma),
                                std::hypot(noise.hand_eye_sigma_deg, noise.arm_sigma_deg), &rng);
  std::vector<Vector3d> p_AO;
  for (const world::Cluster& cluster : seen) p_AO.push_back(cluster.center_C);
  std::vector<cv::Rect2d> boxes;
  for (const world::Cluster& cluster : boxed) boxes.emplace_back(BoundingBox(cluster, model.width));
  views.matches =
      fusion::MatchAcrossCameras(p_AO, boxes, X_WHand.inverse() * X_WHead, model).matches;
  return views;
}

perception::TrainingSet RenderTrainingSet(const std::vector<sim::SceneObject>& things,
                                          std::uint64_t seed) {
  perception::TrainingSet set;
  for (const sim::SceneObject& thing : things) set.classes.push_back(thing.name);
  set.classes.emplace_back(perception::kBackgroundClass);
  std::sort(set.classes.begin(), set.classes.end());
  const auto count = static_cast<int>(set.classes.size()) * kTrainingTables;
  std::vector<std::vector<cv::Mat>> crops(static_cast<std::size_t>(count));
  ParallelFor(count, [&](int i) {
    const std::string& name = set.classes[static_cast<std::size_t>(i / kTrainingTables)];
    const std::uint64_t own = ForkSeed(seed, fmt::format("crops {}", i));
    const sim::Scene table = TrainingTable(i % kTrainingTables, seed);
    const auto thing = std::find_if(things.begin(), things.end(),
                                    [&](const sim::SceneObject& t) { return t.name == name; });
    crops[static_cast<std::size_t>(i)] =
        thing != things.end() ? CropsOf(*thing, table, own) : CropsOfBackground(things, table, own);
  });
  std::uint64_t hash = Fnv1a("");
  for (int i = 0; i < count; ++i) {
    for (const cv::Mat& crop : crops[static_cast<std::size_t>(i)]) {
      const cv::Mat bytes = crop.isContinuous() ? crop : crop.clone();
      hash = Fnv1a(std::string_view(reinterpret_cast<const char*>(bytes.data),
                                    bytes.total() * bytes.elemSize()),
                   hash);
      set.images.push_back(
          {fmt::format("rendered {}", set.images.size()), i / kTrainingTables, crop});
    }
  }
  set.hash = "fnv1a " + HexDigits(hash);
  return set;
}

}  // namespace secondlook::apps
