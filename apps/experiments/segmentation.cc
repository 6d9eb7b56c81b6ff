#include "lib/perception/segment.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "apps/commands/parse_up.h"
#include "apps/experiments/experiment.h"
#include "apps/experiments/free_camera.h"
#include "apps/experiments/random_scene.h"
#include "apps/mission_config.h"
#include "lib/common/error.h"
#include "lib/geometry/pcd.h"

namespace secondlook::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kSimulatedTrials = 50;  // unless told
constexpr int kObjects = 7;           // on a simulated table
constexpr int kLeastInSight = 200;    // points of one

/// The object that a label stands for; 0 for none (not measured, or a part of the table). Labels of
/// one decade are parts of one object, and the first decade is the table's (Modified Object
/// Segmentation Database).
int ObjectOf(std::uint32_t label) { return label < 10 ? 0 : static_cast<int>(label / 10); }

std::vector<fs::path> FindClouds(const std::string& folder) {
  if (!fs::is_directory(folder)) Throw<ConfigError>("{}: no such folder", folder);
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".pcd") files.push_back(entry.path());
  }
  if (files.empty()) Throw<ConfigError>("{}: holds no .pcd", folder);
  std::sort(files.begin(), files.end());
  return files;
}

/// Intersection over union of each true object with the cluster that is matched to it, 0 for those
/// left without: one to one, the best match first.
std::vector<double> MatchedIoU(const std::vector<int>& objects,
                               const std::vector<world::Cluster>& clusters) {
  std::map<int, int> true_points;
  for (const int object : objects) {
    if (object > 0) ++true_points[object];
  }
  std::vector<std::tuple<double, int, int>> overlaps;  // IoU, object, cluster
  for (int c = 0; c < static_cast<int>(clusters.size()); ++c) {
    std::map<int, int> shared;
    for (const int pixel : clusters[c].pixels) {
      if (objects[pixel] > 0) ++shared[objects[pixel]];
    }
    for (const auto& [object, points] : shared) {
      const auto all = static_cast<double>(clusters[c].pixels.size()) + true_points[object];
      overlaps.emplace_back(points / (all - points), object, c);
    }
  }
  std::sort(overlaps.rbegin(), overlaps.rend());
  std::map<int, double> matched;
  std::set<int> taken;
  for (const auto& [iou, object, cluster] : overlaps) {
    if (matched.contains(object) || taken.contains(cluster)) continue;
    matched[object] = iou;
    taken.insert(cluster);
  }
  std::vector<double> ious;
  for (const auto& [object, points] : true_points) ious.push_back(matched[object]);
  return ious;
}

/// A cloud and what is in it.
struct LabelledScene {
  std::string name;
  geometry::PointImage cloud;
  std::vector<int> objects;  ///< By point: its object from 1, 0 for none.
  Eigen::Vector3d up_C;
  double max_tilt_deg{};
  double max_drop{std::numeric_limits<double>::infinity()};
};

LabelledScene ReadScene(const fs::path& file) {
  geometry::LabelledCloud truth = geometry::ReadLabelledPcd(file);
  LabelledScene scene{
      file.filename().string(), std::move(truth.cloud), {}, kImageUp_C, kImageUpTolerance_deg};
  for (const std::uint32_t label : truth.labels) scene.objects.push_back(ObjectOf(label));
  return scene;
}

/// One view of a crowded table, as a mission's camera measures it. A thing of which less than
/// kLeastInSight points are measured is not in sight.
LabelledScene DrawScene(const Repertoire& repertoire, std::uint64_t seed, int trial) {
  Rng rng(ForkSeed(seed, "scene"));
  std::vector<sim::SceneObject> pool = repertoire.known;
  pool.insert(pool.end(), repertoire.unknown.begin(), repertoire.unknown.end());
  const sim::Scene table = DrawCrowdedTable(DrawObjects(std::move(pool), kObjects, &rng), &rng);
  FreeCamera camera(table, seed);
  const Photo photo = camera.Take(DrawView(table.table, &rng));
  const UnderstandingConfig config;
  LabelledScene scene{fmt::format("simulated {}", trial),
                      geometry::Deproject(photo.frame.depth, camera.info().model),
                      {},
                      photo.X_WC.linear().transpose() * Eigen::Vector3d::UnitZ(),
                      config.segment.max_tilt_deg,
                      photo.X_WC.translation().z() - config.floor_clearance_m};
  const auto things = static_cast<int>(table.objects.size());
  std::map<int, int> points;
  for (int i = 0; i < photo.id.rows * photo.id.cols; ++i) {
    const bool measured = geometry::IsMeasured(scene.cloud.points_C[i]);
    const int id = photo.id.at<std::uint16_t>(i / photo.id.cols, i % photo.id.cols);
    const int object = id - sim::kFirstObjectId + 1;
    const bool thing = measured && object >= 1 && object <= things;
    scene.objects.push_back(thing ? object : 0);
    ++points[scene.objects.back()];
  }
  for (int& object : scene.objects) {
    if (points[object] < kLeastInSight) object = 0;
  }
  return scene;
}

Json RunTrial(const LabelledScene& scene) {
  const std::set<int> present(scene.objects.begin(), scene.objects.end());
  Json trial;
  trial["cloud"] = scene.name;
  trial["objects"] = static_cast<int>(present.size()) - static_cast<int>(present.count(0));
  for (const bool split : {true, false}) {
    perception::SegmentConfig config;
    config.max_tilt_deg = scene.max_tilt_deg;
    config.split_touching = split;
    const std::clock_t begin = std::clock();
    const perception::Segmentation found =
        perception::Segment(scene.cloud, scene.up_C, config, scene.max_drop);
    trial[split ? "result" : "without_splitting"] = {
        {"clusters", found.clusters.size()},
        {"iou", MatchedIoU(scene.objects, found.clusters)},
        {"plane", found.plane_C.has_value()},
        {"reason", found.reason},
        {"processor_seconds", static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC}};
  }
  return trial;
}

struct Figures {
  std::vector<double> count_error;  ///< A cloud each.
  std::vector<double> iou;          ///< An object each.
  std::vector<double> seconds;
  int planes{};
  int exact{};
};

Figures Collect(const std::vector<Json>& trials, const char* which) {
  Figures figures;
  for (const Json& trial : trials) {
    const Json& result = trial.at(which);
    const double error =
        std::abs(result.at("clusters").get<double>() - trial.at("objects").get<double>());
    figures.count_error.push_back(error);
    figures.seconds.push_back(result.at("processor_seconds"));
    for (const Json& iou : result.at("iou")) figures.iou.push_back(iou);
    if (result.at("plane")) ++figures.planes;
    if (error == 0.0) ++figures.exact;
  }
  return figures;
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  const Figures ours = Collect(trials, "result");
  const Figures base = Collect(trials, "without_splitting");
  const int count = static_cast<int>(trials.size());
  return {
      {"objects counted, absolute error", Mean(ours.count_error), {}, Mean(base.count_error).value},
      {"IoU of all true objects, unmatched = 0", Mean(ours.iou), {}, Mean(base.iou).value},
      {"clouds with the right count",
       Proportion(ours.exact, count),
       {},
       Proportion(base.exact, count).value},
      {"clouds with a support plane",
       Proportion(ours.planes, count),
       {},
       Proportion(base.planes, count).value},
      {"processor time of a cloud [s]", Mean(ours.seconds), {}, Mean(base.seconds).value}};
}

}  // namespace

void RunSegmentationExperiment(const ExperimentOptions& given) {
  ExperimentOptions options = given;
  options.threads = 1;  // side by side, they would be charged each other's processor time
  if (given.data.empty()) {
    const Repertoire repertoire = LoadRepertoire(given.models, given.unfamiliar);
    if (given.trials == 0) options.trials = kSimulatedTrials;
    RunTrials(
        "segmentation", options,
        [&](int t) {
          const std::uint64_t seed = ForkSeed(options.seed, fmt::format("trial {}", t));
          return RunTrial(DrawScene(repertoire, seed, t));
        },
        Summarise);
    return;
  }
  const std::vector<fs::path> clouds = FindClouds(given.data);
  const auto count = static_cast<int>(clouds.size());
  options.trials = given.trials == 0 ? count : std::min(given.trials, count);
  RunTrials(
      "segmentation", options, [&](int t) { return RunTrial(ReadScene(clouds[t])); }, Summarise);
}

}  // namespace secondlook::apps
