#include "lib/perception/segment.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "apps/commands/parse_up.h"
#include "apps/experiments/experiment.h"
#include "lib/common/error.h"
#include "lib/geometry/pcd.h"

namespace secondlook::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// The object that a label stands for; 0 for none (not measured, or a part of the table). Labels of
/// one decade are parts of one object, and the first decade is the table's (Modified Object
/// Segmentation Database).
int ObjectOf(std::uint32_t label) { return label < 10 ? 0 : static_cast<int>(label / 10); }

std::vector<fs::path> FindClouds(const std::string& folder) {
  if (folder.empty()) {
    Throw<InvalidArgument>("experiment segmentation: --data is missing: a folder of labelled PCDs");
  }
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

Json RunTrial(const fs::path& file) {
  const geometry::LabelledCloud truth = geometry::ReadLabelledPcd(file);
  std::vector<int> objects;
  for (const std::uint32_t label : truth.labels) objects.push_back(ObjectOf(label));
  const std::set<int> present(objects.begin(), objects.end());

  Json trial;
  trial["cloud"] = file.filename().string();
  trial["objects"] = static_cast<int>(present.size()) - static_cast<int>(present.count(0));
  for (const bool split : {true, false}) {
    perception::SegmentConfig config;
    config.max_tilt_deg = kImageUpTolerance_deg;
    config.split_touching = split;
    const std::clock_t begin = std::clock();
    const perception::Segmentation found = perception::Segment(truth.cloud, kImageUp_C, config);
    trial[split ? "result" : "without_splitting"] = {
        {"clusters", found.clusters.size()},
        {"iou", MatchedIoU(objects, found.clusters)},
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
  const std::vector<fs::path> clouds = FindClouds(given.data);
  ExperimentOptions options = given;
  options.trials = std::min(given.trials, static_cast<int>(clouds.size()));
  options.threads = 1;  // side by side, they would be charged each other's processor time
  RunTrials(
      "segmentation", options, [&](int t) { return RunTrial(clouds[t]); }, Summarise);
}

}  // namespace secondlook::apps
